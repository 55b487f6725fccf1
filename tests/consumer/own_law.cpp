// Elastin's command with a law of this program's own among the strategies:
//   own_law compare cube.yaml
#include "columns.h"
#include "elastin/command/command.h"

int main(int argc, char** argv) {
  elastin::Catalog catalog = elastin::built_in_catalog();
  catalog.add<Columns>();
  return elastin::command::run_command(argc, argv, catalog);
}

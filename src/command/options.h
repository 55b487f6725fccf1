#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace elastin::command {

/// Takes the text of a value. Throws InputError where it is wrong; the option's name is put before the message.
using Take = std::function<void(const std::string& text)>;

Take into(std::string& target);
Take into(std::vector<std::string>& target);  ///< adds the text
Take into(int& target, int low, int high);
Take into(std::vector<int>& target, int low, int high);  ///< adds the number
Take into(double& target, double low = -std::numeric_limits<double>::infinity(),
          double high = std::numeric_limits<double>::infinity());
Take one_of(std::vector<std::string> allowed, Take take);
/// Words that are separated by commas, each by itself.
Take each_of(Take take);

/// What one command takes on the command line. Targets must outlive it.
class Options {
 public:
  /// An option, or an argument if its name does not begin with "--".
  struct Option {
    std::string name, value, help;  ///< value: the word that stands for it in the help; empty for a flag
    Take take;
    bool required = false, repeated = false, hidden = false;
    int given = 0;
  };

  void flag(const std::string& name, bool& target, const std::string& help);
  /// The reference is valid until the next option is added.
  Option& add(const std::string& name, const std::string& value, Take take, const std::string& help);
  void argument(const std::string& name, Take take, const std::string& help, bool required, bool repeated);

  /// Reads the words behind the command's name. Gives whether they request help; then nothing is checked further.
  /// Throws InputError: an unknown option with the nearest name, a missing, wrong or superfluous value or argument.
  bool read(const std::vector<std::string>& words, const std::string& usage_name);
  /// How the command is written, and the lists of its arguments and options.
  std::string help(const std::string& usage_name) const;

 private:
  std::string usage(const std::string& usage_name) const;
  Option& find(const std::string& name);
  void take_argument(const std::string& word, const std::string& usage_name);
  void check_complete(const std::string& usage_name) const;

  std::vector<Option> options_, arguments_;
};

/// Two columns: names, padded to one width, and their texts.
std::string help_line(const std::string& name, const std::string& text);

}  // namespace elastin::command

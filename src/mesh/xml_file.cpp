#include "mesh/xml_file.h"

#include <algorithm>
#include <pugixml.hpp>
#include <string_view>
#include <utility>

#include "elastin/core/base/error.h"
#include "mesh/text_file.h"

namespace elastin::mesh {
namespace {

constexpr int kDeepest = 100;

class XmlReader {
 public:
  XmlReader(const std::string& path, std::string bytes) : file_{path, std::move(bytes)} {
    for (std::size_t i = 0; i < file_.bytes.size(); ++i)
      if (file_.bytes[i] == '\n') line_ends_.push_back(static_cast<std::ptrdiff_t>(i));
  }

  XmlElement read() const {
    pugi::xml_document document;
    const auto parsed =
        document.load_buffer(file_.bytes.data(), file_.bytes.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!parsed) throw InputError({file_.path, line(parsed.offset)}, std::string("no XML: ") + parsed.description());
    if (!document.document_element()) throw InputError({file_.path}, "no XML: there is no element");
    return element(document.document_element(), 0);
  }

 private:
  int line(std::ptrdiff_t at) const {
    return 1 + static_cast<int>(std::lower_bound(line_ends_.begin(), line_ends_.end(), at) - line_ends_.begin());
  }

  static std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blanks = " \t\r\n";
    const std::size_t from = text.find_first_not_of(blanks), to = text.find_last_not_of(blanks);
    return from == std::string_view::npos ? std::string_view() : text.substr(from, to - from + 1);
  }

  XmlElement element(const pugi::xml_node& node, int depth) const {
    XmlElement result;
    result.name = node.name();
    result.line = line(node.offset_debug());
    if (depth > kDeepest) throw InputError({file_.path, result.line}, "elements are nested too deep");
    for (const pugi::xml_attribute& attribute : node.attributes())
      result.attributes.emplace_back(attribute.name(), attribute.value());
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() == pugi::node_element) result.children.push_back(element(child, depth + 1));
      if (child.type() != pugi::node_pcdata && child.type() != pugi::node_cdata) continue;
      result.text += (result.text.empty() ? "" : " ") + std::string(trimmed(child.value()));
    }
    return result;
  }

  format::File file_;
  std::vector<std::ptrdiff_t> line_ends_;
};

}  // namespace

XmlElement read_xml(const std::string& path, std::string bytes) { return XmlReader(path, std::move(bytes)).read(); }

}  // namespace elastin::mesh

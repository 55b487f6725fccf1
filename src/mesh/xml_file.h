#pragma once
#include <string>
#include <utility>
#include <vector>

namespace elastin::mesh {

/// An element of an XML file with what is inside it. Comments are left out.
struct XmlElement {
  std::string name;
  std::string text;  ///< without blanks and line ends around it
  int line = 0;      ///< where its name stands, from 1
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlElement> children;

  /// The value of an attribute, or nullptr.
  const std::string* attribute(const std::string& of) const {
    for (const auto& [key, value] : attributes)
      if (key == of) return &value;
    return nullptr;
  }
};

/// The root element of the bytes of a file, which messages name by its path. Throws InputError with file and line if it
/// is not XML, or nested more than 100 deep.
XmlElement read_xml(const std::string& path, std::string bytes);

}  // namespace elastin::mesh

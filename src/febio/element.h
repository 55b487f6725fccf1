#pragma once
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "febio/load_controller.h"
#include "mesh/xml_file.h"

namespace elastin::febio {

/// An element of a model file as its readers see it: whatever is not as expected ends in an InputError with file, line
/// and the element's name.
class Element {
 public:
  /// Both must outlive it.
  Element(const mesh::XmlElement& element, const std::string& file) : element_(&element), file_(&file) {}

  const std::string& name() const { return element_->name; }
  const std::string& text() const { return element_->text; }
  /// Of the attribute, or "".
  std::string attribute(const std::string& name) const;
  std::string needed_attribute(const std::string& name) const;
  /// That attribute as an integer.
  int whole_attribute(const std::string& name) const;

  std::vector<Element> children() const;
  std::optional<Element> find(const std::string& name) const;
  Element at(const std::string& name) const;
  /// Throws on a child with another name.
  void allow(std::initializer_list<const char*> names) const;
  /// Throws on two children of one name that have the same value of this attribute.
  void refuse_twice(const std::string& attribute) const;
  /// Throws on an attribute with another name.
  void allow_attributes(std::initializer_list<const char*> names) const;

  /// Its text as a number that nothing changes in time.
  double number() const;
  /// That of a child; `usual` without such a child.
  double number(const std::string& child, double usual) const;
  double needed_number(const std::string& child) const { return at(child).number(); }
  std::vector<double> numbers(std::size_t count) const;
  /// Integers with commas or blanks between them.
  std::vector<int> integers() const;
  /// A number times its load controller, if any.
  Value value(const LoadControllers& controllers) const;
  /// Its own controller, or none.
  std::shared_ptr<const LoadController> controller(const LoadControllers& controllers) const;

  [[noreturn]] void fail(const std::string& why) const;
  /// Fails: "is not supported here", and why where this is known.
  [[noreturn]] void refuse(const std::string& what, const std::string& why = "") const;
  /// What throws an InputError without a source location gets this one.
  template <class Make>
  auto located(const Make& make) const {
    try {
      return make();
    } catch (const InputError& error) {
      if (error.has_location()) throw;
      fail(error.what());
    }
  }

 private:
  double parse(std::string_view word) const;
  int parse_whole(std::string_view word) const;
  std::vector<std::string_view> words() const;

  const mesh::XmlElement* element_;
  const std::string* file_;
};

}  // namespace elastin::febio

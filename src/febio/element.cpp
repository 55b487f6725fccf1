#include "febio/element.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <utility>

namespace elastin::febio {

std::string Element::attribute(const std::string& name) const {
  const std::string* value = element_->attribute(name);
  return value ? *value : "";
}

std::string Element::needed_attribute(const std::string& name) const {
  if (!element_->attribute(name)) fail("the attribute '" + name + "' is missing");
  return attribute(name);
}

int Element::whole_attribute(const std::string& name) const { return parse_whole(needed_attribute(name)); }

std::vector<Element> Element::children() const {
  std::vector<Element> result;
  for (const mesh::XmlElement& child : element_->children) result.emplace_back(child, *file_);
  return result;
}

std::optional<Element> Element::find(const std::string& name) const {
  std::optional<Element> found;
  for (const mesh::XmlElement& child : element_->children) {
    if (child.name != name) continue;
    if (found) Element(child, *file_).fail("stands here twice");
    found = Element(child, *file_);
  }
  return found;
}

Element Element::at(const std::string& name) const {
  const auto found = find(name);
  if (!found) fail("<" + name + "> is missing");
  return *found;
}

void Element::allow(std::initializer_list<const char*> names) const {
  const std::vector<std::string> known(names.begin(), names.end());
  for (const Element& child : children())
    if (std::find(known.begin(), known.end(), child.name()) == known.end())
      child.fail("is not supported in <" + name() + ">" + suggestion(child.name(), known));
}

void Element::refuse_twice(const std::string& attribute) const {
  std::set<std::pair<std::string, std::string>> seen;
  for (const Element& child : children())
    if (const std::string value = child.attribute(attribute);
        !value.empty() && !seen.emplace(child.name(), value).second)
      child.fail(attribute + "=\"" + value + "\" stands here twice: only one could be in force");
}

void Element::allow_attributes(std::initializer_list<const char*> names) const {
  const std::vector<std::string> known(names.begin(), names.end());
  for (const auto& [key, value] : element_->attributes)
    if (std::find(known.begin(), known.end(), key) == known.end())
      fail("the attribute " + key + "=\"" + value + "\" is not supported" + suggestion(key, known));
}

double Element::number() const {
  allow_attributes({});
  return parse(text());
}

double Element::number(const std::string& child, double usual) const {
  const auto found = find(child);
  return found ? found->number() : usual;
}

std::vector<double> Element::numbers(std::size_t count) const {
  std::vector<double> result;
  for (const std::string_view word : words()) result.push_back(parse(word));
  if (result.size() != count)
    fail("needs " + std::to_string(count) + " numbers with commas between them, not '" + text() + "'");
  return result;
}

std::vector<int> Element::integers() const {
  std::vector<int> result;
  for (const std::string_view word : words()) result.push_back(parse_whole(word));
  return result;
}

std::shared_ptr<const LoadController> Element::controller(const LoadControllers& controllers) const {
  const std::string id = attribute("lc");
  if (id.empty()) return nullptr;
  const auto found = controllers.find(parse_whole(id));
  if (found == controllers.end()) fail("there is no load_controller " + id);
  return found->second;
}

Value Element::value(const LoadControllers& controllers) const {
  if (attribute("type") == "const") {
    allow_attributes({"lc", "type"});
  } else {
    allow_attributes({"lc"});
  }
  return {parse(text()), controller(controllers)};
}

void Element::fail(const std::string& why) const {
  throw InputError({*file_, element_->line}, "<" + name() + ">: " + why);
}

void Element::refuse(const std::string& what, const std::string& why) const {
  fail(what + " is not supported" + (why.empty() ? "" : ": " + why));
}

double Element::parse(std::string_view word) const {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    fail("'" + std::string(word) + "' is no number");
  return value;
}

int Element::parse_whole(std::string_view word) const {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) fail("'" + std::string(word) + "' is no whole number");
  return value;
}

std::vector<std::string_view> Element::words() const {
  constexpr std::string_view between = ", \t\r\n";
  std::vector<std::string_view> result;
  const std::string_view all = text();
  for (std::size_t from = all.find_first_not_of(between); from != std::string_view::npos;) {
    const std::size_t to = std::min(all.find_first_of(between, from), all.size());
    result.push_back(all.substr(from, to - from));
    from = all.find_first_not_of(between, to);
  }
  return result;
}

}  // namespace elastin::febio

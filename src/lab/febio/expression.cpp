#include "lab/febio/expression.h"

#include <charconv>
#include <cmath>

namespace elastin::lab::febio {
namespace {

using Formula = std::function<double(const Vector3&)>;

class Parser {
 public:
  explicit Parser(const Element& element) : element_(element), left_(element.text()) {}

  Formula all() {
    Formula result = sum();
    if (!ended()) fail();
    return result;
  }

 private:
  static constexpr int kDeepest = 50;

  bool ended() {
    left_.remove_prefix(std::min(left_.find_first_not_of(' '), left_.size()));
    return left_.empty();
  }
  bool take(char sign) {
    if (ended() || left_.front() != sign) return false;
    left_.remove_prefix(1);
    return true;
  }
  [[noreturn]] void fail() const {
    element_.fail("cannot read the formula '" + element_.text() + "'" +
                  (left_.empty() ? ": it ends too early" : " at '" + std::string(left_.substr(0, 12)) + "'") +
                  "; it may have numbers, X, Y, Z, + - * / ^ and parentheses");
  }

  Formula sum() {
    Formula result = product();
    while (true) {
      if (take('+'))
        result = [a = result, b = product()](const Vector3& x) { return a(x) + b(x); };
      else if (take('-'))
        result = [a = result, b = product()](const Vector3& x) { return a(x) - b(x); };
      else
        return result;
    }
  }
  Formula product() {
    Formula result = signed_power();
    while (true) {
      if (take('*'))
        result = [a = result, b = signed_power()](const Vector3& x) { return a(x) * b(x); };
      else if (take('/'))
        result = [a = result, b = signed_power()](const Vector3& x) { return a(x) / b(x); };
      else
        return result;
    }
  }
  Formula signed_power() {
    if (++depth_ > kDeepest) fail();
    Formula result;
    if (take('-')) {
      result = [a = signed_power()](const Vector3& x) { return -a(x); };
    } else {
      result = single();
      if (take('^')) result = [a = result, b = signed_power()](const Vector3& x) { return std::pow(a(x), b(x)); };
    }
    --depth_;
    return result;
  }
  Formula single() {
    if (take('(')) {
      Formula result = sum();
      if (!take(')')) fail();
      return result;
    }
    for (int axis = 0; axis < 3; ++axis)
      if (take("XYZ"[axis])) return [axis](const Vector3& x) { return x[axis]; };
    if (ended()) fail();
    double number = 0;
    const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), number);
    if (error != std::errc() || !std::isfinite(number)) fail();
    left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
    return [number](const Vector3&) { return number; };
  }

  const Element& element_;
  std::string_view left_;
  int depth_ = 0;
};

}  // namespace

std::function<double(const Vector3& place)> read_expression(const Element& element) { return Parser(element).all(); }

}  // namespace elastin::lab::febio

#pragma once
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/rest.h"

namespace elastin {

/// Length of each connection without stress [m]: the rest length, times what Body::unstressed says. The body must
/// outlive it.
class UnstressedLengths {
 public:
  explicit UnstressedLengths(const Body& body) : body_(&body) { set(1); }

  /// See Elasticity::set_rest.
  void set(double part) {
    if (!body_->unstressed) return;
    own_ = body_->connections.rest_length;
    for (std::size_t c = 0; c < own_.size(); ++c) {
      const auto& [a, b] = body_->connections.ends[c];
      const Vector3 first = body_->rest.col(a), second = body_->rest.col(b), middle = (first + second) / 2;
      if (first == second) continue;
      own_[c] *= body_->unstressed->length ? 1 + part * (body_->unstressed->length(first, second) - 1)
                                           : (body_->unstressed->at(middle, middle, part) * (second - first)).norm() /
                                                 (second - first).norm();
    }
  }
  const double* data() const { return own_.empty() ? body_->connections.rest_length.data() : own_.data(); }
  double operator[](int connection) const { return data()[connection]; }

 private:
  const Body* body_;
  std::vector<double> own_;  ///< empty: the rest lengths
};

}  // namespace elastin

#pragma once
#include <optional>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin::lab {

/// Rows between two turning points of what is prescribed.
struct Branch {
  Eigen::Index begin = 0, end = 0;  ///< [begin, end)
  bool loading = true;              ///< in the direction of the first one
};
/// In the order of the rows; less than a twentieth of the whole range is no turn.
std::vector<Branch> branches_of(const VectorX& x);

/// Rows [begin, end) in which what is prescribed stands still while the reading changes, as it does where a material
/// relaxes; without the row that the way there ends with.
struct Hold {
  Eigen::Index begin, end;
  double changed;  ///< of the largest reading, below 0 where its size falls
};
/// In the order of the rows: five or more within 0.5 % of the range, that move a tenth as fast as rows next to them at
/// most. Those at rest that a test begins with are none.
/// @param rest the value of x at rest
std::vector<Hold> find_holds(const VectorX& x, const VectorX& y, double rest, double noise);

/// Where a specimen tears: the first of the readings whose median of three has lost a fifth within three rows, or the
/// first behind the largest one where less than half of that is left; and the share that is lost. None: it does not
/// tear, or there are too few rows to say so. Of a branch that begins near rest.
struct Tear {
  Eigen::Index row;
  double lost;
};
std::optional<Tear> find_tear(const VectorX& x, const VectorX& y, double noise);

/// Standard deviation of the readings below a fifth of the largest, by the median of their fourth differences, which
/// see no smooth curve; 0 of fewer than 30 rows.
double noise_of(const VectorX& x, const VectorX& y);

/// Where the load begins, with its 95 % interval.
struct ZeroPoint {
  double value, low, high;
};
/// Of y = k d + m d², d = max(0, x − zero), k ≥ 0, over the rows up to three tenths of the largest reading: in front of
/// it a specimen is slack; before the first row if the specimen is preloaded. None of fewer than 10 rows.
std::optional<ZeroPoint> find_zero(const VectorX& x, const VectorX& y);
/// Whether that fits to the noise, and far better than a power, an exponential or a parabola that begin at x = 0:
/// slack, and no toe of a tissue.
bool begins_late(const VectorX& x, const VectorX& y, double noise);
/// Of the line through the steepest fifth of the range [ASTM D638, annex on toe compensation].
std::optional<ZeroPoint> find_toe(const VectorX& x, const VectorX& y);

/// Least squares over the rows with x in [low, high] of a polynomial, of a lower degree where there are too few rows.
struct LocalFit {
  double value, slope;            ///< at `at`
  double value_half, slope_half;  ///< half widths of their 95 % intervals; infinite where no row is left for them
  Eigen::Index rows;
};
/// @param chord whether the slope is the rise from `low` to `high` over their distance, `at` their middle
std::optional<LocalFit> fit_locally(const VectorX& x, const VectorX& y, double at, double low, double high,
                                    Eigen::Index degree, bool chord = false);

}  // namespace elastin::lab

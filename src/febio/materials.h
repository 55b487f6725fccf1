#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/laws/point_laws.h"
#include "febio/element.h"
#include "febio/stepped_cells.h"

namespace elastin::febio {

/// A law at work at one point, its type forgotten, with an energy or without.
class LawTerm {
 public:
  virtual ~LawTerm() = default;
  virtual bool has_energy() const = 0;
  virtual Matrix3 stress(const Matrix3& A) const = 0;
  virtual TangentModuli<3> tangent(const Matrix3& A) const = 0;
  virtual double energy(const Matrix3& A) const = 0;
};
/// A material at one point is a sum of laws.
using LawTerms = std::vector<std::shared_ptr<const LawTerm>>;

/// Where a law is put to work: at a point of a cell at rest.
struct PointPlace {
  Vector3 point;
  Eigen::MatrixXd nodes;  ///< of the cell [m], a column each
  int cell = 0;           ///< its number in its domain
};

/// <ElementData>: numbers of each cell of a domain.
struct CellData {
  std::string domain;
  std::vector<std::vector<double>> values;
};

/// A material of a model file.
struct Material {
  std::string name, id;
  bool rigid = false;                  ///< the body moves as a whole
  std::optional<Vector3> centre = {};  ///< of a rigid body, about which it turns; none: its centre of mass
  double density = 1;
  double youngs_modulus = 1, poissons_ratio = 0;  ///< at rest, of the matrix
  bool has_energy = true;
  bool even = true;              ///< whether its laws are the same at all points
  std::optional<CellData> data;  ///< of the only domain that it may have
  std::function<LawTerms(const PointPlace& place)> terms;
  /// U(J) of an uncoupled material; the terms are then its change of shape alone.
  std::optional<Volumetric> volume;
  /// Of the terms, which are those at rest: U(J) does not relax.
  std::optional<Relaxation> relaxation;

  /// Whether its cells must see the time of each increment.
  bool follows_time() const { return relaxation.has_value(); }
};

/// What constants that change in time refer to.
struct MaterialTime {
  const LoadControllers& controllers;
  std::shared_ptr<const double> now;  ///< [s], as the steps set it
  const std::map<std::string, CellData>& data;
};

/// Reads <material>, or <solid> of a mixture.
Material read_material(const Element& element, const MaterialTime& time);

/// The material on the cells of a block. `whole_cell`: its volume is kept by the mean dilatation of each cell.
/// The body must outlive it.
/// @param stepped whether increments have forces that are not those at their ends.
ElasticTerms make_domain(const Body& body, const CellBlock& block, const Material& material, bool whole_cell,
                         std::shared_ptr<const Clock> clock, bool stepped);

}  // namespace elastin::febio

#include "febio/materials.h"

#include <cmath>
#include <map>

#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "core/laws/solids/transversely_isotropic.h"
#include "core/laws/solids/yeoh.h"
#include "core/model/block_geometry.h"
#include "elastin/core/forces/block_cells.h"
#include "febio/muscle.h"

namespace elastin::febio {
namespace {

template <class Law>
class TypedTerm final : public LawTerm {
 public:
  explicit TypedTerm(Law law) : law_(std::move(law)) {}
  bool has_energy() const override { return HasEnergyDensity<Law, 3>; }
  Matrix3 stress(const Matrix3& A) const override { return law_.stress(A); }
  TangentModuli<3> tangent(const Matrix3& A) const override { return law_.tangent(A); }
  double energy(const Matrix3& A) const override {
    if constexpr (HasEnergyDensity<Law, 3>) return law_.energy(A);
    return 0;
  }

 private:
  Law law_;
};

template <class Law>
std::shared_ptr<const LawTerm> term_of(Law law) {
  return std::make_shared<TypedTerm<Law>>(std::move(law));
}

/// A law times a number.
class ScaledTerm final : public LawTerm {
 public:
  ScaledTerm(std::shared_ptr<const LawTerm> term, double factor) : term_(std::move(term)), factor_(factor) {}
  bool has_energy() const override { return term_->has_energy(); }
  Matrix3 stress(const Matrix3& A) const override { return factor_ * term_->stress(A); }
  TangentModuli<3> tangent(const Matrix3& A) const override { return factor_ * term_->tangent(A); }
  double energy(const Matrix3& A) const override { return factor_ * term_->energy(A); }

 private:
  std::shared_ptr<const LawTerm> term_;
  double factor_;
};

/// A law that sees F F_p, whose Cauchy stress is the one that it says of that: S = F_p S(F_pᵀ C F_p) F_pᵀ / J_p.
class PrestrainedTerm final : public LawTerm {
 public:
  /// @param prestrain F_p now
  PrestrainedTerm(std::shared_ptr<const LawTerm> term, std::function<Matrix3()> prestrain)
      : term_(std::move(term)), prestrain_(std::move(prestrain)) {}
  bool has_energy() const override { return term_->has_energy(); }
  Matrix3 stress(const Matrix3& A) const override {
    const Matrix3 F = prestrain_();
    return F * term_->stress(seen(F, A)) * F.transpose() / F.determinant();
  }
  TangentModuli<3> tangent(const Matrix3& A) const override {
    const Matrix3 F = prestrain_();
    TangentModuli<3> turn;  // of stresses; that of strains is its transpose
    for (int k = 0; k < 6; ++k) turn.col(k) = components(F * tensor(Components(Components::Unit(k))) * F.transpose());
    return turn * term_->tangent(seen(F, A)) * turn.transpose() / F.determinant();
  }
  double energy(const Matrix3& A) const override {
    const Matrix3 F = prestrain_();
    return term_->energy(seen(F, A)) / F.determinant();
  }

 private:
  static Matrix3 seen(const Matrix3& F, const Matrix3& A) {
    return F.transpose() * A * F + F.transpose() * F - Matrix3::Identity();
  }
  std::shared_ptr<const LawTerm> term_;
  std::function<Matrix3()> prestrain_;
};

/// U(J) alone.
struct NoShape {
  Matrix3 stress(const Matrix3&) const { return Matrix3::Zero(); }
  TangentModuli<3> tangent(const Matrix3&) const { return TangentModuli<3>::Zero(); }
  double energy(const Matrix3&) const { return 0; }
};
using VolumeOnly = SplitPoint<NoShape>;

/// S = C E of a constant C, E = A/2.
struct LinearSolid {
  TangentModuli<3> moduli;  ///< ∂S/∂C

  Matrix3 stress(const Matrix3& A) const {
    Components strain = components(A);
    strain.tail<3>() *= 2;  // both components of the shears
    return tensor(Components(moduli * strain));
  }
  TangentModuli<3> tangent(const Matrix3&) const { return moduli; }
  double energy(const Matrix3& A) const { return stress(A).cwiseProduct(A).sum() / 4; }
};

/// F(λ) of fibres along a, λ² = a · C a: as TransverselyIsotropic has it, of the whole stretch.
struct WholeStretchFibres {
  Vector3 direction;
  TransverselyIsotropic::Fibres fibres;

  Matrix3 stress(const Matrix3& A) const {
    const double u = extension(A), square = (1 + u) * (1 + u);
    return fibres.tension(u) / square * direction * direction.transpose();
  }
  TangentModuli<3> tangent(const Matrix3& A) const {
    const double u = extension(A), square = (1 + u) * (1 + u);
    const Components along = symmetric_product(direction, direction);
    return (fibres.slope(u) * (1 + u) / 2 - fibres.tension(u)) / (square * square) * along * along.transpose();
  }
  double energy(const Matrix3& A) const { return fibres.energy(extension(A)); }

 private:
  double extension(const Matrix3& A) const {
    const double change = std::max(direction.dot(A * direction), -1.);
    return change / (1 + std::sqrt(1 + change));
  }
};

/// A muscle's own stress T(λ̃) along its fibres, by the calcium that is there:
///   T = T_max a(t) e/(e + (Ca_max/Ca₀)²),  e = exp(β (λ̃ refl − l₀)) − 1.       [Guccione, Waldman & McCulloch 1993]
/// S = J T/λ² a aᵀ has no energy, for J and λ̃ are those of the whole deformation.
struct ActiveContraction {
  Vector3 direction = Vector3::UnitX();
  double most, calcium, rate, rest_length, length;  ///< T_max [Pa], (Ca_max/Ca₀)², β, l₀, refl
  Value activation;
  std::shared_ptr<const double> now;

  Matrix3 stress(const Matrix3& A) const {
    const Present at(*this, A);
    return at.J * at.tension / at.square * direction * direction.transpose();
  }
  TangentModuli<3> tangent(const Matrix3& A) const {
    const Present at(*this, A);
    const Components along = symmetric_product(direction, direction), inverse = components(at.inverse);
    const Components change = at.J / at.square *
                              (at.tension * (inverse / 2 - along / at.square) +
                               at.slope * at.stretch * (along / (2 * at.square) - inverse / 6));
    return along * change.transpose();
  }

 private:
  struct Present {
    double J, square, stretch, tension = 0, slope = 0;  ///< λ², λ̃; T and its slope by λ̃
    Matrix3 inverse;                                    ///< C⁻¹

    Present(const ActiveContraction& law, const Matrix3& A) {
      const Dilatation volume(A);
      inverse = volume.inverse;
      J = volume.J();
      square = std::max(1 + law.direction.dot(A * law.direction), 1e-12);
      stretch = std::sqrt(square) / std::cbrt(J);
      const double longer = stretch * law.length - law.rest_length;
      if (longer < 0) return;
      const double full = law.most * law.activation.at(*law.now), grown = std::exp(law.rate * longer);
      const double whole = grown - 1 + law.calcium;
      tension = full * (grown - 1) / whole;
      slope = full * law.rate * law.length * grown * law.calcium / (whole * whole);
    }
  };
};

/// The laws of all points of a block.
class DomainLaws final : public PointLaws<3> {
 public:
  /// @param points one for all, or one a point.
  DomainLaws(std::vector<LawTerms> points, std::size_t points_a_cell)
      : points_(std::move(points)), points_a_cell_(points_.size() == 1 ? 0 : points_a_cell) {
    for (const LawTerms& terms : points_)
      for (const auto& term : terms) has_energy_ &= term->has_energy();
  }

  bool has_energy() const override { return has_energy_; }
  void stresses(int cell, std::span<const Matrix3> A, std::span<Matrix3> S) const override {
    for (std::size_t g = 0; g < A.size(); ++g) {
      S[g].setZero();
      for (const auto& term : at(cell, g)) S[g] += term->stress(A[g]);
    }
  }
  void tangents(int cell, std::span<const Matrix3> A, std::span<TangentModuli<3>> D) const override {
    for (std::size_t g = 0; g < A.size(); ++g) {
      D[g].setZero();
      for (const auto& term : at(cell, g)) D[g] += term->tangent(A[g]);
    }
  }
  double energy(int cell, std::span<const Matrix3> A, std::span<const double> weights) const override {
    double sum = 0;
    for (std::size_t g = 0; g < A.size(); ++g)
      if (weights[g] != 0)
        for (const auto& term : at(cell, g)) sum += weights[g] * term->energy(A[g]);
    return sum;
  }

 private:
  const LawTerms& at(int cell, std::size_t g) const {
    return points_[points_a_cell_ == 0 ? 0 : static_cast<std::size_t>(cell) * points_a_cell_ + g];
  }
  std::vector<LawTerms> points_;
  std::size_t points_a_cell_;
  bool has_energy_ = true;
};

// --- reading ---------------------------------------------------------------------------------------------------------

/// Directions of fibres at rest, unit vectors.
struct FibreDirections {
  bool even = true;
  std::function<Vector3(const PointPlace&)> at;
};

/// The vector turned as the x axis turns into `radius`, of length 1, on the shortest way. [Rodrigues]
Vector3 turned_as_x_into(const Vector3& radius, const Vector3& vector) {
  const double cosine = radius.x();
  if (1 + cosine < 1e-12) return {-vector.x(), vector.y(), -vector.z()};  // half a turn, about y
  const Vector3 axis = Vector3::UnitX().cross(radius);
  return cosine * vector + axis.cross(vector) + axis.dot(vector) / (1 + cosine) * axis;
}

Vector3 unit(const Element& element, const std::vector<double>& numbers) {
  const Vector3 vector(numbers[0], numbers[1], numbers[2]);
  if (!(vector.norm() > 0)) element.fail("a direction of no length");
  return vector.normalized();
}

FibreDirections read_fibre(const Element& element) {
  const std::string type = element.needed_attribute("type");
  element.allow_attributes({"type"});
  if (type == "vector") {
    element.allow({"vector"});
    Vector3 direction = unit(element, element.at("vector").numbers(3));
    return {true, [direction](const PointPlace&) { return direction; }};
  }
  if (type == "local") {
    element.allow({"local"});
    const std::vector<int> ends = element.at("local").integers();
    if (ends.size() != 2 || ends[0] < 1 || ends[1] < 1) element.at("local").fail("needs two numbers of nodes, from 1");
    return {false, [ends, element](const PointPlace& place) -> Vector3 {
              if (std::max(ends[0], ends[1]) > place.nodes.cols()) element.fail("a cell has no such node");
              const Vector3 edge = place.nodes.col(ends[1] - 1) - place.nodes.col(ends[0] - 1);
              return edge.normalized();
            }};
  }
  if (type == "spherical") {
    element.allow({"center", "vector"});
    const std::vector<double> center = element.at("center").numbers(3);
    const Vector3 middle(center[0], center[1], center[2]);
    Vector3 vector = Vector3::UnitX();
    if (const auto given = element.find("vector")) vector = unit(*given, given->numbers(3));
    return {false, [middle, vector](const PointPlace& place) -> Vector3 {
              return turned_as_x_into((place.point - middle).normalized(), vector);
            }};
  }
  if (type == "angles") {
    element.allow({"theta", "phi"});
    const double degree = EIGEN_PI / 180, theta = element.needed_number("theta") * degree,
                 phi = element.needed_number("phi") * degree;
    const Vector3 a(std::cos(theta) * std::sin(phi), std::sin(theta) * std::sin(phi), std::cos(phi));
    return {true, [a](const PointPlace&) { return a; }};
  }
  element.refuse("type=\"" + type + "\"", "vector, local, spherical and angles are");
}

/// The numbers that every material has in addition to its own.
void allow_numbers(const Element& element, std::initializer_list<const char*> own) {
  std::vector<std::string> known(own.begin(), own.end());
  known.emplace_back("density");
  for (const Element& child : element.children())
    if (std::find(known.begin(), known.end(), child.name()) == known.end())
      child.fail("is not supported in a material of type " + element.attribute("type") +
                 suggestion(child.name(), known));
}

double positive(const Element& element, const std::string& name) {
  const double value = element.needed_number(name);
  if (!(value > 0)) element.at(name).fail("must be above 0");
  return value;
}

struct Lame {
  double lambda, mu;
};
Lame read_lame(const Element& element, Material& material) {
  allow_numbers(element, {"E", "v"});
  const double E = positive(element, "E"), nu = element.needed_number("v");
  if (!(nu > -1 && nu < 0.5)) element.at("v").fail("Poisson's ratio must be above -1 and below 0.5");
  material.youngs_modulus = E;
  material.poissons_ratio = nu;
  return {E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))};
}

/// The law is the same everywhere.
template <class Law>
void set_even(Material& material, Law law) {
  material.terms = [term = term_of(std::move(law))](const PointPlace&) { return LawTerms{term}; };
}

void set_moduli(Material& material, double mu) {
  const double K = material.volume->modulus;
  if (!(mu > 0 && K > 0)) return;
  material.youngs_modulus = 9 * K * mu / (3 * K + mu);
  material.poissons_ratio = (3 * K - 2 * mu) / (2 * (3 * K + mu));
}

void read_uncoupled(const Element& element, Material& material) {
  const double K = element.needed_number("k");
  if (!(K >= 0)) element.at("k").fail("must be 0 or more");
  Volumetric volume{Volumetric::Form::logarithmic, K};
  if (const auto model = element.find("pressure_model")) {
    const std::string& form = model->text();
    if (form == "NIKE3D" || form == "1")
      volume.form = Volumetric::Form::mixed;
    else if (form == "Abaqus" || form == "2")
      volume.form = Volumetric::Form::quadratic;
    else if (form != "default" && form != "0")
      model->refuse("'" + form + "'", "default, NIKE3D and Abaqus are");
  }
  material.volume = volume;
}

TransverselyIsotropic::Fibres read_toe_and_line(const Element& element, const char* stretch) {
  const double c4 = element.number("c4", 0), c5 = element.number("c5", 0), straight = element.number(stretch, 1);
  double c3 = element.number("c3", 0);
  if (c3 == 0 && c5 != 0) {
    if (c4 == 0) element.fail("needs c4 where c3 is 0: c3 = c5/c4 exp(-c4 (" + std::string(stretch) + " - 1))");
    c3 = c5 / c4 * std::exp(-c4 * (straight - 1));
  }
  if (!(straight >= 1)) element.at(stretch).fail("must be 1 or more");
  return {c3, c4, c5, straight};
}

using Read = void (*)(const Element& element, Material& material, const MaterialTime& time);

void read_neo_hookean(const Element& element, Material& material, const MaterialTime&) {
  const auto [lambda, mu] = read_lame(element, material);
  set_even(material, SplitPoint<NeoHookean::Solid>{NeoHookean::Solid{0, mu}, {Volumetric::Form::logarithmic, lambda}});
}

void read_isotropic(const Element& element, Material& material, const MaterialTime&) {
  const auto [lambda, mu] = read_lame(element, material);
  set_even(material, StVenantKirchhoff::Solid{lambda, mu});
}

void read_orthotropic(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"E1", "E2", "E3", "G12", "G23", "G31", "v12", "v23", "v31"});
  const double E1 = positive(element, "E1"), E2 = positive(element, "E2"), E3 = positive(element, "E3");
  const double v12 = element.needed_number("v12"), v23 = element.needed_number("v23"),
               v31 = element.needed_number("v31");
  Matrix3 compliance;
  compliance << 1 / E1, -v12 / E1, -v31 / E3, -v12 / E1, 1 / E2, -v23 / E2, -v31 / E3, -v23 / E2, 1 / E3;
  if (!(compliance.topLeftCorner<2, 2>().determinant() > 0 && compliance.determinant() > 0))
    element.fail("these moduli and Poisson's ratios give no positive stiffness");
  LinearSolid law{TangentModuli<3>::Zero()};
  law.moduli.topLeftCorner<3, 3>() = compliance.inverse() / 2;
  law.moduli(3, 3) = positive(element, "G12") / 2;
  law.moduli(4, 4) = positive(element, "G31") / 2;
  law.moduli(5, 5) = positive(element, "G23") / 2;
  material.youngs_modulus = E1;
  material.poissons_ratio = v12;
  set_even(material, law);
}

void read_mooney_rivlin(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"k", "pressure_model", "c1", "c2"});
  read_uncoupled(element, material);
  const double c1 = element.needed_number("c1"), c2 = element.number("c2", 0);
  set_moduli(material, 2 * (c1 + c2));
  set_even(material, IsotropicShape<MooneyRivlin::Density>{{c1, c2}});
}

void read_ogden(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element,
                {"k", "pressure_model", "c1", "c2", "c3", "c4", "c5", "c6", "m1", "m2", "m3", "m4", "m5", "m6"});
  read_uncoupled(element, material);
  Ogden::Shape law;
  double mu = 0;
  for (const char* term : {"1", "2", "3", "4", "5", "6"}) {
    const double c = element.number(std::string("c") + term, 0), m = element.number(std::string("m") + term, 1);
    if (c == 0) continue;
    if (m == 0) element.at(std::string("m") + term).fail("must not be 0");
    law.terms.add(c, m);
    mu += c / 2;
  }
  set_moduli(material, mu);
  set_even(material, law);
}

void read_yeoh(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"k", "pressure_model", "c1", "c2", "c3", "c4", "c5", "c6"});
  read_uncoupled(element, material);
  Yeoh::Density law{{}, 6};
  for (std::size_t i = 0; i < 6; ++i) law.c[i] = element.number("c" + std::to_string(i + 1), 0);
  set_moduli(material, 2 * law.c[0]);
  set_even(material, IsotropicShape<Yeoh::Density>{law});
}

/// Laws along fibres, whose directions may change from point to point.
template <class Law>
void set_along(Material& material, const Element& fibre, const Law& law) {
  const FibreDirections directions = read_fibre(fibre);
  material.even = directions.even;
  material.terms = [directions, law](const PointPlace& place) {
    Law own = law;
    own.direction = directions.at(place);
    return LawTerms{term_of(own)};
  };
}

ActiveContraction read_active_contraction(const Element& element, const MaterialTime& time) {
  element.allow({"ascl", "Tmax", "ca0", "camax", "beta", "l0", "refl"});
  ActiveContraction law;
  law.most = element.number("Tmax", 1);
  const double usual = element.number("ca0", 1), given = element.number("camax", 0);
  if (!(usual > 0)) element.at("ca0").fail("must be above 0");
  law.calcium = given == 0 ? 1 : given / usual * given / usual;
  law.rate = element.needed_number("beta");
  law.rest_length = element.needed_number("l0");
  law.length = element.needed_number("refl");
  law.activation = element.at("ascl").value(time.controllers);
  law.now = time.now;
  return law;
}

void read_transversely_isotropic(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element,
                {"k", "pressure_model", "c1", "c2", "c3", "c4", "c5", "lam_max", "fiber", "active_contraction"});
  read_uncoupled(element, material);
  const double c1 = element.needed_number("c1"), c2 = element.number("c2", 0);
  set_moduli(material, 2 * (c1 + c2));
  set_along(material, element.at("fiber"),
            TransverselyIsotropic::Shape{c1, c2, Vector3::UnitX(), read_toe_and_line(element, "lam_max")});
  const auto active = element.find("active_contraction");
  if (!active) return;
  const ActiveContraction law = read_active_contraction(*active, time);
  material.has_energy = false;
  material.terms = [passive = material.terms, law,
                    directions = read_fibre(element.at("fiber"))](const PointPlace& place) {
    LawTerms terms = passive(place);
    ActiveContraction own = law;
    own.direction = directions.at(place);
    terms.push_back(term_of(own));
    return terms;
  };
}

void read_muscle(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(
      element, {"k", "pressure_model", "g1", "g2", "g3", "p1", "p2", "Lofl", "smax", "lam_max", "activation", "fiber"});
  read_uncoupled(element, material);
  Muscle law{.direction = Vector3::UnitX(),
             .along = element.number("g1", 0),
             .across = element.number("g2", 0),
             .matrix = element.number("g3", 0),
             .passive = element.needed_number("p1"),
             .rate = element.needed_number("p2"),
             .optimal = positive(element, "Lofl"),
             .straight = element.needed_number("lam_max"),
             .peak = element.needed_number("smax"),
             .activation = element.number("activation", 0)};
  law.straight /= law.optimal;
  if (!(law.straight >= 1)) element.at("lam_max").fail("must be Lofl or more");
  if (!(law.rate >= 0 && law.rate * (law.straight - 1) <= 500))
    element.at("p2").fail("must be 0 or more, and p2 (lam_max/Lofl - 1) at most 500");
  set_moduli(material, 2 * law.across);
  set_along(material, element.at("fiber"), law);
}

void read_fibre_exp_linear(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"c3", "c4", "c5", "lambda", "fiber"});
  set_along(material, element.at("fiber"), WholeStretchFibres{Vector3::UnitX(), read_toe_and_line(element, "lambda")});
}

void read_uncoupled_fibre_exp_linear(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"k", "pressure_model", "c3", "c4", "c5", "lambda", "fiber"});
  read_uncoupled(element, material);
  set_along(material, element.at("fiber"),
            TransverselyIsotropic::Shape{0, 0, Vector3::UnitX(), read_toe_and_line(element, "lambda")});
}

/// Adds the laws of each <solid>.
void add_solids(const Element& element, Material& material, const MaterialTime& time) {
  std::vector<Material> solids;
  for (const Element& child : element.children()) {
    if (child.name() != "solid") continue;
    solids.push_back(read_material(child, time));
    const Material& solid = solids.back();
    if (solid.volume.has_value() != material.volume.has_value())
      child.refuse("type=\"" + child.attribute("type") + "\" in a " + element.attribute("type"),
                   material.volume ? "all solids of one must be uncoupled" : "no solid of one may be uncoupled");
    if (solid.volume && solid.volume->modulus != 0)
      child.at("k").refuse("a k of its own in an uncoupled solid mixture", "give it in the mixture");
    material.even &= solid.even;
    material.has_energy &= solid.has_energy;
  }
  if (solids.empty()) element.fail("<solid> is missing");
  if (!material.volume) {
    material.youngs_modulus = solids.front().youngs_modulus;
    material.poissons_ratio = solids.front().poissons_ratio;
  }
  material.terms = [solids](const PointPlace& place) {
    LawTerms all;
    for (const Material& solid : solids)
      for (auto& term : solid.terms(place)) all.push_back(std::move(term));
    return all;
  };
}

void read_mixture(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"solid"});
  add_solids(element, material, time);
}

void read_uncoupled_mixture(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"k", "pressure_model", "solid"});
  read_uncoupled(element, material);
  add_solids(element, material, time);
}

/// g₀ + Σ gᵢ e^(−t/tᵢ) times the stress of <elastic>, or of its change of shape.
void read_relaxing(const Element& element, Material& material, const MaterialTime& time) {
  const Element elastic = element.at("elastic");
  const Material solid = read_material(elastic, time);
  if (solid.relaxation) elastic.refuse("a viscoelastic material in another");
  if (solid.volume.has_value() != material.volume.has_value())
    elastic.refuse("type=\"" + elastic.attribute("type") + "\" in a material of type " + element.attribute("type"),
                   material.volume ? "it must be uncoupled" : "it may not be uncoupled");
  const double rest = element.number("g0", 1);
  if (!(rest > 0)) element.at("g0").fail("must be above 0");
  Relaxation relaxation;
  for (int i = 1; i <= 6; ++i) {
    const std::string number = std::to_string(i);
    const double share = element.number("g" + number, 0), length = element.number("t" + number, 1);
    if (!(share >= 0)) element.at("g" + number).fail("must be 0 or more");
    if (!(length > 0)) element.at("t" + number).fail("must be above 0");
    if (share > 0) relaxation.terms.push_back({share / rest, length});
  }
  material.even = solid.even;
  material.has_energy = solid.has_energy;
  material.youngs_modulus = solid.youngs_modulus;
  material.poissons_ratio = solid.poissons_ratio;
  if (material.volume) material.volume->modulus += solid.volume->modulus;
  material.terms = solid.terms;
  if (rest != 1)
    material.terms = [terms = solid.terms, rest](const PointPlace& place) {
      LawTerms all = terms(place);
      for (auto& term : all) term = std::make_shared<ScaledTerm>(std::move(term), rest);
      return all;
    };
  if (!relaxation.terms.empty()) material.relaxation = relaxation;
}

void read_viscoelastic(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"g0", "g1", "g2", "g3", "g4", "g5", "g6", "t1", "t2", "t3", "t4", "t5", "t6", "elastic"});
  read_relaxing(element, material, time);
}

void read_uncoupled_viscoelastic(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"k", "pressure_model", "g0", "g1", "g2", "g3", "g4", "g5", "g6", "t1", "t2", "t3", "t4", "t5",
                          "t6", "elastic"});
  read_uncoupled(element, material);
  read_relaxing(element, material, time);
}

/// The laws of <elastic> under a prestrain F_p = I + …, by the direction of fibres there.
void set_prestrained(const Element& element, Material& material, const MaterialTime& time,
                     const std::optional<FibreDirections>& fibres,
                     const std::function<Matrix3(const Vector3& fibre, int cell)>& prestrain) {
  const Element elastic = element.at("elastic");
  const Material solid = read_material(elastic, time);
  if (solid.volume || solid.relaxation)
    elastic.refuse("type=\"" + elastic.attribute("type") + "\" in a material of type " + element.attribute("type"),
                   "it may be neither uncoupled nor viscoelastic");
  material.even = solid.even && (!fibres || fibres->even) && !material.data;
  material.has_energy = solid.has_energy;
  material.youngs_modulus = solid.youngs_modulus;
  material.poissons_ratio = solid.poissons_ratio;
  material.terms = [terms = solid.terms, fibres, prestrain](const PointPlace& place) {
    const Vector3 fibre = fibres ? fibres->at(place) : Vector3(Vector3::UnitX());
    LawTerms all = terms(place);
    for (auto& term : all)
      term = std::make_shared<PrestrainedTerm>(
          std::move(term), [prestrain, fibre, cell = place.cell] { return prestrain(fibre, cell); });
    return all;
  };
}

/// a I + (b − 1) n nᵀ
Matrix3 along_and_across(const Vector3& n, double a, double b) {
  return a * Matrix3::Identity() + (b - 1) * n * n.transpose();
}

/// F_p = F_g⁻¹ of <growth>.
void read_growth(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"elastic", "growth"});
  const Element growth = element.at("growth");
  const std::string type = growth.needed_attribute("type");
  const auto value = [&](const char* name) {
    growth.allow({name, "fiber"});
    return growth.at(name).value(time.controllers);
  };
  std::function<Matrix3(const Vector3&)> metric;
  if (type == "volume growth") {
    metric = [m = value("multiplier"), now = time.now](const Vector3& n) { return along_and_across(n, m.at(*now), 1); };
  } else if (type == "area growth") {
    metric = [m = value("multiplier"), now = time.now](const Vector3& n) {
      const double across = std::sqrt(m.at(*now));
      return along_and_across(n, across, 2 - across);
    };
  } else if (type == "fiber growth") {
    metric = [m = value("multiplier"), now = time.now](const Vector3& n) { return along_and_across(n, 1, m.at(*now)); };
  } else if (type == "general growth") {
    growth.allow({"iso", "ani", "fiber"});
    metric = [iso = growth.at("iso").value(time.controllers), ani = growth.at("ani").value(time.controllers),
              now = time.now](const Vector3& n) { return along_and_across(n, iso.at(*now), ani.at(*now)); };
  } else {
    growth.refuse("type=\"" + type + "\"");
  }
  const auto fibre = growth.find("fiber");
  set_prestrained(element, material, time, fibre ? std::optional(read_fibre(*fibre)) : std::nullopt,
                  [metric](const Vector3& n, int) { return Matrix3(metric(n).inverse()); });
}

/// Whether an element names <ElementData>, which the material then has.
bool read_data(const Element& element, std::size_t numbers, const MaterialTime& time, Material& material) {
  if (element.attribute("type").empty()) return false;
  if (element.attribute("type") != "map") element.refuse("type=\"" + element.attribute("type") + "\"", "map is");
  const auto found = time.data.find(element.text());
  if (found == time.data.end()) element.fail("there is no <ElementData> '" + element.text() + "'");
  for (const std::vector<double>& row : found->second.values)
    if (row.size() != numbers) element.fail("needs " + std::to_string(numbers) + " numbers for each cell");
  material.data = found->second;
  return true;
}

void read_prestrain(const Element& element, Material& material, const MaterialTime& time) {
  allow_numbers(element, {"elastic", "prestrain"});
  const Element prestrain = element.at("prestrain");
  const std::string type = prestrain.needed_attribute("type");
  if (type == "prestrain gradient") {
    prestrain.allow({"ramp", "F0"});
    const Element F0 = prestrain.at("F0");
    const std::vector<std::vector<double>> all =
        read_data(F0, 9, time, material) ? material.data->values : std::vector<std::vector<double>>{F0.numbers(9)};
    std::vector<Matrix3> changes;
    for (const std::vector<double>& numbers : all)
      changes.push_back(Eigen::Map<const Matrix3>(numbers.data()).transpose() - Matrix3::Identity());
    const auto ramp = prestrain.find("ramp");
    set_prestrained(
        element, material, time, std::nullopt,
        [part = ramp ? ramp->value(time.controllers) : Value{1}, changes, now = time.now](const Vector3&, int cell) {
          return Matrix3(Matrix3::Identity() +
                         part.at(*now) * changes[changes.size() > 1 ? static_cast<std::size_t>(cell) : 0]);
        });
  } else if (type == "in-situ stretch") {
    prestrain.allow({"stretch", "isochoric"});
    const bool isochoric = prestrain.number("isochoric", 1) != 0;
    const Element stretch = prestrain.at("stretch");
    std::vector<Value> stretches;
    if (read_data(stretch, 1, time, material))
      for (const std::vector<double>& row : material.data->values) stretches.push_back({row[0]});
    else
      stretches.push_back(stretch.value(time.controllers));
    set_prestrained(element, material, time, read_fibre(element.at("elastic").at("fiber")),
                    [stretches, isochoric, now = time.now](const Vector3& n, int cell) {
                      const double along =
                                       stretches[stretches.size() > 1 ? static_cast<std::size_t>(cell) : 0].at(*now),
                                   across = isochoric ? 1 / std::sqrt(along) : 1;
                      return along_and_across(n, across, 1 + along - across);
                    });
  } else {
    prestrain.refuse("type=\"" + type + "\"");
  }
}

/// c1 (I1 − 3) − 2 c1 ln J + k/2 ln² J, and fibres by the whole stretch.
void read_coupled_trans_iso(const Element& element, Material& material, const MaterialTime&) {
  allow_numbers(element, {"c1", "c2", "c3", "c4", "c5", "lam_max", "k", "fiber"});
  if (element.number("c2", 0) != 0) element.at("c2").refuse("c2 other than 0");
  const double mu = 2 * positive(element, "c1"), k = positive(element, "k");
  set_along(material, element.at("fiber"), WholeStretchFibres{{}, read_toe_and_line(element, "lam_max")});
  material.terms = [fibres = material.terms,
                    matrix = term_of(SplitPoint<NeoHookean::Solid>{
                        NeoHookean::Solid{0, mu}, {Volumetric::Form::logarithmic, k}})](const PointPlace& place) {
    LawTerms all = fibres(place);
    all.push_back(matrix);
    return all;
  };
  material.youngs_modulus = mu * (3 * k + 2 * mu) / (k + mu);
  material.poissons_ratio = k / (2 * (k + mu));
}

const std::map<std::string, Read>& readers() {
  static const std::map<std::string, Read> table{
      {"neo-Hookean", read_neo_hookean},
      {"isotropic elastic", read_isotropic},
      {"orthotropic elastic", read_orthotropic},
      {"Mooney-Rivlin", read_mooney_rivlin},
      {"Ogden", read_ogden},
      {"Yeoh", read_yeoh},
      {"trans iso Mooney-Rivlin", read_transversely_isotropic},
      {"muscle material", read_muscle},
      {"fiber-exp-linear", read_fibre_exp_linear},
      {"uncoupled fiber-exp-linear", read_uncoupled_fibre_exp_linear},
      {"solid mixture", read_mixture},
      {"uncoupled solid mixture", read_uncoupled_mixture},
      {"kinematic growth", read_growth},
      {"prestrain elastic", read_prestrain},
      {"coupled trans-iso Mooney-Rivlin", read_coupled_trans_iso},
      {"viscoelastic", read_viscoelastic},
      {"uncoupled viscoelastic", read_uncoupled_viscoelastic},
  };
  return table;
}

}  // namespace

Material read_material(const Element& element, const MaterialTime& time) {
  element.allow_attributes({"id", "name", "type"});
  const std::string type = element.needed_attribute("type");
  const auto read = readers().find(type);
  if (read == readers().end()) {
    std::vector<std::string> known;
    for (const auto& [name, reader] : readers()) known.push_back(name);
    element.fail("a material of type \"" + type + "\" is not supported" + suggestion(type, known));
  }
  Material material;
  material.name = element.attribute("name"), material.id = element.attribute("id");
  material.density = element.number("density", 1);
  if (!(material.density > 0)) element.at("density").fail("must be above 0");
  read->second(element, material, time);
  return material;
}

namespace {

/// The laws of the points of a block, with U(J) at each where `with_volume`.
std::shared_ptr<const DomainLaws> laws_of(const Body& body, const CellBlock& block, const Material& material,
                                          bool with_volume) {
  const CellKind& kind = *block.kind;
  std::vector<LawTerms> points;
  for (int cell = 0; cell < (material.even ? 1 : block.size()); ++cell) {
    PointPlace place{Vector3::Zero(), positions_of(body.rest, block.cell(cell)), cell};
    for (Eigen::Index g = 0; g < (material.even ? 1 : kind.weights.size()); ++g) {
      place.point = place.nodes * kind.values.col(g);
      points.push_back(material.terms(place));
      if (with_volume) points.back().push_back(term_of(VolumeOnly{{}, *material.volume}));
    }
  }
  return std::make_shared<DomainLaws>(std::move(points), static_cast<std::size_t>(kind.weights.size()));
}

/// The cells' change of shape relaxes, their volume stays as elastic as it was.
ElasticTerms make_relaxing(const Body& body, const CellBlock& block, const Material& material, bool whole_cell) {
  auto shape = make_block_cells<3>(body, block, laws_of(body, block, material, false));
  shape->relax(*material.relaxation);
  ElasticTerms terms = std::move(shape);
  if (!material.volume) return terms;
  if (whole_cell)
    terms.add(make_block_cells<3>(body, block, {AnyPoint<3>(NoShape{})}, {*material.volume}));
  else
    terms.add(make_block_cells<3>(body, block, {AnyPoint<3>(VolumeOnly{{}, *material.volume})}));
  return terms;
}

}  // namespace

ElasticTerms make_domain(const Body& body, const CellBlock& block, const Material& material, bool whole_cell,
                         std::shared_ptr<const Clock> clock, bool stepped) {
  const auto laws = laws_of(body, block, material, material.volume && !whole_cell);
  ElasticTerms cells = material.relaxation             ? make_relaxing(body, block, material, whole_cell)
                       : material.volume && whole_cell ? make_block_cells<3>(body, block, laws, {*material.volume})
                                                       : make_block_cells<3>(body, block, laws);
  if (!stepped && !material.follows_time()) return cells;
  return make_stepped_cells(body, block, std::move(cells), laws, std::move(clock));
}

}  // namespace elastin::febio

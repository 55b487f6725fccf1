#include "elastin/core/model/subdomain.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace elastin {
namespace {

/// Shares out `molecules` among the owners first … first + parts − 1.
void bisect(const Positions& positions, std::span<int> molecules, int first, int parts, std::vector<int>& owners) {
  if (parts == 1) {
    for (const int molecule : molecules) owners[molecule] = first;
    return;
  }
  Vector3 low = Vector3::Constant(INFINITY), high = -low;
  for (const int molecule : molecules) {
    low = low.cwiseMin(positions.col(molecule));
    high = high.cwiseMax(positions.col(molecule));
  }
  // Of sides that are equally long up to rounding the last, along which lattices are numbered slowest.
  const Vector3 size = high - low;
  int axis = 2;
  for (const int other : {1, 0})
    if (size[other] > size[axis] * (1 + 1e-9)) axis = other;
  const int lower = parts / 2;
  const auto middle =
      molecules.begin() +
      static_cast<std::ptrdiff_t>(molecules.size() * static_cast<std::size_t>(lower) / static_cast<std::size_t>(parts));
  std::nth_element(molecules.begin(), middle, molecules.end(), [&](int a, int b) {
    const double at_a = positions(axis, a), at_b = positions(axis, b);
    return at_a < at_b || (at_a == at_b && a < b);
  });
  bisect(positions, {molecules.begin(), middle}, first, lower, owners);
  bisect(positions, {middle, molecules.end()}, first + lower, parts - lower, owners);
}

template <std::size_t nodes>
int lowest(const std::array<int, nodes>& cell) {
  return *std::min_element(cell.begin(), cell.end());
}

/// Chooses molecules and elements of the whole.
class SubdomainBuilder {
 public:
  SubdomainBuilder(const Body& whole, const std::vector<int>& owners, int own)
      : whole_(whole), owners_(owners), own_(own) {}

  Subdomain subdomain() {
    result_.whole = &whole_;
    set_molecules();
    set_connections();
    keep_cells(whole_.triangles, body_.triangles, result_.triangles);
    keep_cells(whole_.tetrahedra, body_.tetrahedra, result_.tetrahedra);
    result_.body = std::make_shared<const Body>(std::move(body_));
    return std::move(result_);
  }

 private:
  bool owns(int molecule) const { return owners_[molecule] == own_; }
  int local(int molecule) const { return local_[molecule]; }

  void set_molecules() {
    std::vector<char> reached(owners_.size(), 0);
    const auto reach = [&](const auto& nodes) {
      for (const int molecule : nodes) reached[molecule] = 1;
    };
    for (const auto& ends : whole_.connections.ends)
      if (owns(ends[0])) reach(ends);
    for (const auto& cell : whole_.triangles)
      if (owns(lowest(cell))) reach(cell);
    for (const auto& cell : whole_.cubes)
      if (owns(lowest(cell))) reach(cell);
    for (const auto& cell : whole_.tetrahedra)
      if (std::any_of(cell.begin(), cell.end(), [&](int molecule) { return owns(molecule); })) reach(cell);
    for (const bool ghosts : {false, true})
      for (int molecule = 0; molecule < whole_.size(); ++molecule)
        if (ghosts ? !owns(molecule) && reached[molecule] : owns(molecule)) {
          result_.molecules.push_back(molecule);
          result_.owned += !ghosts;
        }
    local_.assign(owners_.size(), -1);
    for (std::size_t i = 0; i < result_.molecules.size(); ++i) local_[result_.molecules[i]] = static_cast<int>(i);
    body_.rest = whole_.rest(Eigen::all, result_.molecules);
    if (whole_.mass.size()) body_.mass = whole_.mass(result_.molecules);  // equilibria do without
    if (whole_.radius.size()) body_.radius = whole_.radius(result_.molecules);
  }

  void set_connections() {
    const bool cells = !whole_.triangles.empty() || !whole_.tetrahedra.empty() || !whole_.cubes.empty();
    const Connections& all = whole_.connections;
    Connections& own = body_.connections;
    for (int c = 0; c < all.size(); ++c) {
      const auto& [a, b] = all.ends[c];
      const bool computes = owns(a);
      if (!computes && !cells) continue;  // only cells need the connections that others compute
      const int first = local(a), second = local(b);
      if (first < 0 || second < 0) continue;
      own.ends.push_back({first, second});
      own.rest_length.push_back(all.rest_length[c]);
      own.cell_sides += c >= all.proper();
      result_.connections.push_back(c);
      result_.computes.push_back(computes);
    }
  }

  template <std::size_t nodes>
  void keep_cells(const std::vector<std::array<int, nodes>>& all, std::vector<std::array<int, nodes>>& own,
                  std::vector<int>& numbers) const {
    for (std::size_t number = 0; number < all.size(); ++number) {
      if (!owns(lowest(all[number]))) continue;
      auto cell = all[number];
      for (int& molecule : cell) molecule = local(molecule);
      own.push_back(cell);
      numbers.push_back(static_cast<int>(number));
    }
  }

  const Body& whole_;
  const std::vector<int>& owners_;
  int own_;
  std::vector<int> local_;  // number in the subdomain of each molecule, −1 where it is not there
  Body body_;
  Subdomain result_;
};

}  // namespace

int Subdomain::local(int molecule) const {
  const auto ghosts = molecules.begin() + owned;
  for (const auto& [begin, end] : {std::pair{molecules.begin(), ghosts}, std::pair{ghosts, molecules.end()}})
    if (const auto at = std::lower_bound(begin, end, molecule); at != end && *at == molecule)
      return static_cast<int>(at - molecules.begin());
  return -1;
}

VectorX Subdomain::computed(const VectorX& of_whole) const {
  VectorX values(static_cast<Eigen::Index>(connections.size()));
  for (std::size_t c = 0; c < connections.size(); ++c)
    values[static_cast<Eigen::Index>(c)] = computes[c] ? of_whole[connections[c]] : 0;
  return values;
}

std::vector<int> bisect(const Positions& positions, int parts) {
  std::vector<int> owners(positions.cols()), molecules(owners.size());
  std::iota(molecules.begin(), molecules.end(), 0);
  bisect(positions, molecules, 0, parts, owners);
  return owners;
}

Subdomain make_subdomain(const Body& body, const std::vector<int>& owners, int own) {
  return SubdomainBuilder(body, owners, own).subdomain();
}

}  // namespace elastin

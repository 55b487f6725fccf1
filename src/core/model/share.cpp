#include "elastin/core/model/share.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/archive.h"
#include "core/model/visit_body.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// What process 0 says before a share: what it could not make, or that all are to make the whole.
enum Word : int { share_follows, failed, make_whole };

template <class Archive>
void visit_numbers(Archive& archive, std::vector<std::int64_t>& numbers) {
  numbers.resize(archive.count(numbers.size(), sizeof(std::int64_t)));
  for (std::int64_t& number : numbers) {
    int low = static_cast<int>(number % (1 << 30)), high = static_cast<int>(number / (1 << 30));
    archive.whole(low);
    archive.whole(high);
    number = std::int64_t{high} * (1 << 30) + low;
  }
}

template <class Archive>
void visit_share(Archive& archive, Body& body, Share& share) {
  visit(archive, body);
  archive.whole(share.owned);
  visit_numbers(archive, share.number);
  visit_numbers(archive, share.place);
  std::vector<std::int64_t> counts{share.molecules, share.connections, share.cells};
  visit_numbers(archive, counts);
  share.molecules = counts[0], share.connections = counts[1], share.cells = counts[2];
}

std::vector<char> packed(Word word, std::string text) {
  ByteWriter writer;
  int number = word;
  writer.whole(number);
  writer.word(text);
  return writer.take();
}

std::vector<char> packed(Body body) {
  ByteWriter writer;
  int number = share_follows;
  std::string nothing;
  Share share = *body.share;
  writer.whole(number);
  writer.word(nothing);
  visit_share(writer, body, share);
  return writer.take();
}

/// Chooses what of a body a share has.
class ShareBuilder {
 public:
  ShareBuilder(const Body& body, const Owners& owners, int own) : body_(body), owners_(owners), own_(own) {}

  Body make() {
    std::vector<char> near(body_.size());
    for (int molecule = 0; molecule < body_.size(); ++molecule) near[molecule] = owners_.of(molecule) == own_;
    near = with_neighbours(with_neighbours(near));
    auto share = std::make_shared<Share>();
    for (const bool ghosts : {false, true})
      for (int molecule = 0; molecule < body_.size(); ++molecule) {
        if (!near[molecule] || ghosts == (owners_.of(molecule) == own_)) continue;
        molecules_.push_back(molecule);
        share->owned += !ghosts;
        share->number.push_back(owners_.number(molecule));
        share->place.push_back(owners_.place(molecule));
      }
    share->molecules = owners_.molecules;
    share->connections = body_.connections.proper();
    share->cells = static_cast<std::int64_t>(count_cells(body_));
    local_.assign(body_.size(), -1);
    for (std::size_t i = 0; i < molecules_.size(); ++i) local_[molecules_[i]] = static_cast<int>(i);
    Body result = elements();
    result.share = std::move(share);
    return result;
  }

 private:
  std::vector<char> with_neighbours(const std::vector<char>& chosen) const {
    std::vector<char> reached = chosen;
    const auto reach = [&](const auto& element) {
      if (std::any_of(element.begin(), element.end(), [&](int m) { return chosen[m] != 0; }))
        for (const int molecule : element) reached[molecule] = 1;
    };
    for (const auto& ends : body_.connections.ends) reach(ends);
    for (const auto& cell : body_.triangles) reach(cell);
    for (const auto& cell : body_.tetrahedra) reach(cell);
    for (const auto& cell : body_.cubes) reach(cell);
    for (const CellBlock& block : body_.blocks)
      for (int cell = 0; cell < block.size(); ++cell) reach(block.cell(cell));
    return reached;
  }

  template <class Elements>
  std::vector<int> keep(const Elements& all, Elements& own) const {
    std::vector<int> numbers;
    for (std::size_t number = 0; number < all.size(); ++number) {
      auto element = all[number];
      for (int& molecule : element) molecule = local_[molecule];
      if (*std::min_element(element.begin(), element.end()) < 0) continue;
      own.push_back(element);
      numbers.push_back(static_cast<int>(number));
    }
    return numbers;
  }

  /// Of each molecule; of those at the edge whose ends others have nothing.
  void set_between(Body& result) const {
    if (body_.between.empty()) return;
    result.between.resize(molecules_.size());
    const int first = body_.size() - static_cast<int>(body_.between.size());
    for (std::size_t i = 0; i < molecules_.size(); ++i) {
      if (molecules_[i] < first) continue;
      MoleculeBetween own = body_.between[molecules_[i] - first];
      for (auto& [molecule, weight] : own) molecule = local_[molecule];
      if (std::all_of(own.begin(), own.end(), [](const auto& end) { return end.first >= 0; }))
        result.between[i] = std::move(own);
    }
  }

  Body elements() const {
    Body result;
    result.rest = body_.rest(Eigen::all, molecules_);
    result.outline = body_.outline;
    if (body_.mass.size()) result.mass = body_.mass(molecules_);
    if (body_.radius.size()) result.radius = body_.radius(molecules_);
    const std::vector<int> connections = keep(body_.connections.ends, result.connections.ends);
    for (const int c : connections) {
      result.connections.rest_length.push_back(body_.connections.rest_length[c]);
      result.connections.cell_sides += c >= body_.connections.proper();
    }
    if (body_.connection_stiffness.size()) result.connection_stiffness = body_.connection_stiffness(connections);
    const std::vector<int> triangles = keep(body_.triangles, result.triangles),
                           tetrahedra = keep(body_.tetrahedra, result.tetrahedra);
    if (body_.cell_stiffness.size())
      result.cell_stiffness = body_.cell_stiffness(body_.tetrahedra.empty() ? triangles : tetrahedra);
    keep(body_.cubes, result.cubes);
    set_between(result);
    for (const CellBlock& block : body_.blocks) {
      CellBlock own{block.kind, {}, {}};
      std::vector<int> cells;
      for (int cell = 0; cell < block.size(); ++cell) {
        const auto nodes = block.cell(cell);
        const auto has = [&](int molecule) { return local_[molecule] >= 0; };
        if (!std::all_of(nodes.begin(), nodes.end(), has)) continue;
        for (const int molecule : nodes) own.nodes.push_back(local_[molecule]);
        cells.push_back(cell);
      }
      if (block.stiffness.size()) own.stiffness = block.stiffness(cells);
      result.blocks.push_back(std::move(own));
    }
    return result;
  }

  const Body& body_;
  const Owners& owners_;
  int own_;
  std::vector<int> molecules_, local_;
};

}  // namespace

Body make_share(const Body& body, const Owners& owners, int own) { return ShareBuilder(body, owners, own).make(); }

std::string unsuited_for_shares(const Body& body) {
  if (!body.parts.empty()) return "it is put together from several bodies";
  if (!body.cables.empty()) return "it has cables";
  if (body.voronoi) return "it has Voronoi cells";
  return "";
}

Body share_out(const std::function<Body()>& make, const std::shared_ptr<const Processes>& processes, std::string& why) {
  why.clear();
  Body own;
  if (processes->rank() == 0) {
    const auto say = [&](Word word, const std::string& text) {
      for (int to = 1; to < processes->count(); ++to) processes->send(to, packed(word, text));
    };
    Body whole;
    try {
      whole = make();
    } catch (const std::exception& error) {
      say(failed, error.what());
      throw;
    }
    why = unsuited_for_shares(whole);
    if (why.empty() && whole.size() < processes->count()) why = "it has fewer molecules than there are processes";
    if (!why.empty()) {
      say(make_whole, why);
      return whole;
    }
    const std::vector<int> owner = bisect(whole.rest, processes->count());
    std::vector<std::int64_t> place(owner.size()), next(processes->count() + 1, 0);
    for (const int one : owner) ++next[one + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t molecule = 0; molecule < owner.size(); ++molecule) place[molecule] = next[owner[molecule]]++;
    const Owners owners{[&](int molecule) { return owner[molecule]; },
                        [](int molecule) { return std::int64_t{molecule}; },
                        [&](int molecule) { return place[molecule]; }, whole.size()};
    for (int to = 1; to < processes->count(); ++to) processes->send(to, packed(make_share(whole, owners, to)));
    own = make_share(whole, owners, 0);
  } else {
    const std::vector<char> bytes = processes->receive(0);
    ByteReader reader(bytes.data(), bytes.size(), "a share of the body");
    int word = 0;
    std::string text;
    reader.whole(word);
    reader.word(text);
    if (word == failed) throw InputError(text);
    if (word == make_whole) {
      why = text;
      return make();
    }
    auto share = std::make_shared<Share>();
    visit_share(reader, own, *share);
    own.share = std::move(share);
  }
  auto share = std::make_shared<Share>(*own.share);
  share->processes = processes;
  own.share = std::move(share);
  return own;
}

Subdomain computed_by(const Body& share) {
  Subdomain own;
  own.whole = &share;
  own.body = std::shared_ptr<const Body>(std::shared_ptr<const Body>(), &share);
  own.owned = share.share->owned;
  own.molecules.resize(share.size());
  std::iota(own.molecules.begin(), own.molecules.end(), 0);
  own.connections.resize(share.connections.size());
  std::iota(own.connections.begin(), own.connections.end(), 0);
  for (int c = 0; c < share.connections.size(); ++c) own.computes.push_back(computes(share, c));
  const auto choose = [&](const auto& cells, std::vector<int>& chosen) {
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      if (own.owns(lowest_in_whole(share, cells[cell]))) chosen.push_back(static_cast<int>(cell));
  };
  choose(share.triangles, own.triangles);
  choose(share.tetrahedra, own.tetrahedra);
  if (share.triangles.empty() && share.tetrahedra.empty() && share.blocks.empty()) return own;
  Body body = share;
  const auto keep = [](auto& cells, const std::vector<int>& chosen) {
    for (std::size_t i = 0; i < chosen.size(); ++i) cells[i] = cells[chosen[i]];
    cells.resize(chosen.size());
  };
  keep(body.triangles, own.triangles);
  keep(body.tetrahedra, own.tetrahedra);
  for (std::size_t at = 0; at < body.blocks.size(); ++at) {
    const CellBlock& all = share.blocks[at];
    CellBlock& block = body.blocks[at];
    std::vector<int> cells;
    block.nodes.clear();
    for (int cell = 0; cell < all.size(); ++cell) {
      const auto nodes = all.cell(cell);
      if (!own.owns(lowest_in_whole(share, nodes))) continue;
      block.nodes.insert(block.nodes.end(), nodes.begin(), nodes.end());
      cells.push_back(cell);
    }
    if (all.stiffness.size()) block.stiffness = all.stiffness(cells);
  }
  own.body = std::make_shared<const Body>(std::move(body));
  return own;
}

std::vector<double> gathered_over(const Body& body, std::span<const double> own) {
  return body.share ? body.share->processes->gather(own) : std::vector<double>(own.begin(), own.end());
}

void sum_over(const Body& body, std::span<double> own) {
  if (!body.share) return;
  const std::vector<double> all = body.share->processes->gather(own);
  std::fill(own.begin(), own.end(), 0.);
  for (std::size_t i = 0; i < all.size(); ++i) own[i % own.size()] += all[i];
}

double sum_over(const Body& body, double own) {
  sum_over(body, std::span(&own, 1));
  return own;
}

void Processes::largest(std::span<double> own) const {
  const std::vector<double> all = gather(own);
  for (std::size_t i = 0; i < all.size(); ++i) own[i % own.size()] = std::max(own[i % own.size()], all[i]);
}

void largest_over(const Body& body, std::span<double> own) {
  if (body.share) body.share->processes->largest(own);
}

double largest_over(const Body& body, double own) {
  largest_over(body, std::span(&own, 1));
  return own;
}

double least_over(const Body& body, double own) { return -largest_over(body, -own); }

bool any_over(const Body& body, bool own) { return largest_over(body, own) > 0; }

std::string first_over(const Body& body, const std::string& own) {
  if (!body.share) return own;
  const Processes& processes = *body.share->processes;
  const auto size = static_cast<double>(own.size());
  const std::vector<double> sizes = processes.gather(std::span(&size, 1));
  const std::vector<double> letters(own.begin(), own.end()), all = processes.gather(letters);
  std::size_t start = 0;
  for (const double one : sizes) {
    if (one > 0) {
      std::string first;
      for (std::size_t i = 0; i < static_cast<std::size_t>(one); ++i) first += static_cast<char>(all[start + i]);
      return first;
    }
    start += static_cast<std::size_t>(one);
  }
  return "";
}

/// Halves the range of the bits, which are ordered as the numbers are, of those that it can still be.
double nth_over(const Body& body, const std::vector<double>& own, std::int64_t nth) {
  const auto bits_of = [](double number) { return Eigen::numext::bit_cast<std::uint64_t>(number); };
  std::vector<double> left = own;
  while (true) {
    constexpr double none = std::numeric_limits<double>::infinity();
    std::array<double, 2> ends{-none, -none};  // largest, − least
    for (const double number : left) ends[0] = std::max(ends[0], number), ends[1] = std::max(ends[1], -number);
    largest_over(body, ends);
    const std::uint64_t low = bits_of(std::abs(ends[1])), high = bits_of(ends[0]);
    if (!(low < high)) return ends[0];
    const std::uint64_t middle = low + (high - low) / 2;
    const auto above =
        std::partition(left.begin(), left.end(), [&](double number) { return bits_of(number) <= middle; });
    const double below = sum_over(body, static_cast<double>(above - left.begin()));
    if (below > static_cast<double>(nth)) {
      left.erase(above, left.end());
    } else {
      nth -= static_cast<std::int64_t>(below);
      left.erase(left.begin(), above);
    }
  }
}

int owned_molecules(const Body& body) { return body.share ? body.share->owned : body.size(); }

bool computes(const Body& body, int connection) { return body.connections.ends[connection][0] < owned_molecules(body); }

std::int64_t molecules_of_whole(const Body& body) { return body.share ? body.share->molecules : body.size(); }

std::int64_t number_in_whole(const Body& body, int molecule) {
  return body.share ? body.share->number[molecule] : molecule;
}

int molecule_of_whole(const Body& body, std::int64_t number) {
  if (!body.share) return number >= 0 && number < body.size() ? static_cast<int>(number) : -1;
  const auto& numbers = body.share->number;
  const auto first = numbers.begin(), ghosts = first + body.share->owned;
  for (const auto& [from, to] : {std::pair{first, ghosts}, std::pair{ghosts, numbers.end()}})
    if (const auto at = std::lower_bound(from, to, number); at != to && *at == number)
      return static_cast<int>(at - first);
  return -1;
}

void mark_ghosts_as_owners(const Body& body, std::vector<char>& marks) {
  if (!body.share) return;
  std::vector<double> own;  // exact to 2⁵³
  for (int molecule = 0; molecule < owned_molecules(body); ++molecule)
    if (marks[molecule]) own.push_back(static_cast<double>(number_in_whole(body, molecule)));
  std::fill(marks.begin() + owned_molecules(body), marks.end(), 0);
  for (const double number : gathered_over(body, own))
    if (const int molecule = molecule_of_whole(body, static_cast<std::int64_t>(number)); molecule >= 0)
      marks[molecule] = 1;
}

Vector3 middle_of_whole(const Body& body) {
  if (!body.share) return body.rest.rowwise().mean();
  Vector3 sum = body.rest.leftCols(owned_molecules(body)).rowwise().sum();
  sum_over(body, {sum.data(), 3});
  return sum / static_cast<double>(molecules_of_whole(body));
}

std::array<Vector3, 2> outline_of_whole(const Body& body) {
  std::array<Vector3, 2> outline{body.rest.rowwise().minCoeff(), body.rest.rowwise().maxCoeff()};
  if (!body.share) return outline;
  for (int k = 0; k < 3; ++k) {
    outline[0][k] = least_over(body, outline[0][k]);
    outline[1][k] = largest_over(body, outline[1][k]);
  }
  return outline;
}

std::pair<double, double> lengths_of_whole(const Body& body) {
  using Pair = Eigen::Vector2d;
  Pair sums = ordered_sum<Pair>(
      body.connections.size(),
      [&](int c) -> Pair {
        if (!computes(body, c)) return Pair::Zero();
        return {body.connections.rest_length[c], 1};
      },
      Pair::Zero());
  sum_over(body, std::span<double>(sums.data(), 2));
  return {sums[0], sums[1]};
}

}  // namespace elastin

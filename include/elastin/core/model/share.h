#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/model/subdomain.h"

namespace elastin {

/// Processes that have one body among them. All of them call `gather` together, in the same order, and each gets the
/// same result, bitwise.
class Processes {
 public:
  virtual ~Processes() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  /// The numbers of all processes, one process after the other.
  virtual std::vector<double> gather(std::span<const double> own) const = 0;
  /// Makes each number the largest that a process has in its place.
  virtual void largest(std::span<double> own) const;
  /// Hands bytes from one process to another, which waits for them.
  virtual void send(int to, const std::vector<char>& bytes) const = 0;
  virtual std::vector<char> receive(int from) const = 0;
};

/// What makes a body one process's share of a whole (Body::share). It has the molecules that the process owns, in the
/// order of the whole, and behind them, in this order too, two layers of ghosts: molecules of others that elements join
/// to its own, and those that elements join to these. It has all elements of the whole between these molecules, so that
/// constants of what it computes are those of the whole.
struct Share {
  std::shared_ptr<const Processes> processes;
  int owned = 0;                            ///< molecules
  std::vector<std::int64_t> number;         ///< of each molecule in the whole
  std::vector<std::int64_t> place;          ///< the same where the molecules are counted process by process
  std::int64_t molecules = 0;               ///< of the whole
  std::int64_t connections = 0, cells = 0;  ///< of the whole: connections proper, count_cells
};

/// Which molecules each process owns.
struct Owners {
  std::function<int(int molecule)> of;               ///< of each molecule of the body at hand
  std::function<std::int64_t(int molecule)> number;  ///< in the whole; ascending
  std::function<std::int64_t(int molecule)> place;   ///< counted process by process
  std::int64_t molecules = 0;                        ///< of the whole
};

/// The share of process `own`, out of a body that has all that it needs: the whole, or what of a lattice lies around
/// the share. Without Share::processes; connections and cells are counted of the body at hand.
Body make_share(const Body& body, const Owners& owners, int own);

/// Why a whole body cannot be given out in shares, in words for a user; "" if it can.
std::string unsuited_for_shares(const Body& body);

/// Process 0 makes the whole, halves it across its longest side and halves these, and sends each process its share.
/// What it throws all throw. Where the body cannot be given out so, every process makes the whole: `why` says it.
Body share_out(const std::function<Body()>& make, const std::shared_ptr<const Processes>& processes, std::string& why);

/// Its own body as a subdomain: the elements that its process computes, under its own numbers. A connection is computed
/// by the owner of its first molecule, a cell by that of its lowest in the whole. `share` must outlive it.
Subdomain computed_by(const Body& share);

/// Over all processes that have the body; of a whole body the values themselves.
double sum_over(const Body& body, double own);
void sum_over(const Body& body, std::span<double> own);
inline Vector3 vector_sum_over(const Body& body, Vector3 own) {
  sum_over(body, std::span<double>(own.data(), 3));
  return own;
}
double largest_over(const Body& body, double own);
void largest_over(const Body& body, std::span<double> own);
double least_over(const Body& body, double own);
bool any_over(const Body& body, bool own);
/// The first that is not empty.
std::string first_over(const Body& body, const std::string& own);
/// The numbers of all, one process after the other.
std::vector<double> gathered_over(const Body& body, std::span<const double> own);
/// The number that has this many of all numbers below it, 0 … count − 1. Numbers must not be negative.
double nth_over(const Body& body, const std::vector<double>& own, std::int64_t nth);

/// Molecules that come first and are its process's own; all of a whole body.
int owned_molecules(const Body& body);
/// Whether this process computes a connection.
bool computes(const Body& body, int connection);
/// Of the whole.
std::int64_t molecules_of_whole(const Body& body);
/// The number of a molecule in the whole.
std::int64_t number_in_whole(const Body& body, int molecule);
/// The own number of a molecule of the whole; −1 where this process does not have it.
int molecule_of_whole(const Body& body, std::int64_t number);
/// Marks one a molecule, right for owned ones: makes those of ghosts what their owners say. Takes messages as long as
/// what is marked.
void mark_ghosts_as_owners(const Body& body, std::vector<char>& marks);
/// Mean position of the whole's molecules at rest [m].
Vector3 middle_of_whole(const Body& body);
/// Of an element's molecules that which is lowest in the whole.
template <class Element>
int lowest_in_whole(const Body& body, const Element& element) {
  return *std::min_element(element.begin(), element.end(),
                           [&](int a, int b) { return number_in_whole(body, a) < number_in_whole(body, b); });
}
/// Corners of the outline of the whole at rest [m]: lowest, highest.
std::array<Vector3, 2> outline_of_whole(const Body& body);
/// Sum of the rest lengths of the whole's connections [m], and how many they are.
std::pair<double, double> lengths_of_whole(const Body& body);

}  // namespace elastin

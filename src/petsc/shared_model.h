#pragma once
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/subdomain.h"
#include "petsc/handles.h"

namespace elastin::petsc {

/// A body among the processes of a communicator. PETSc numbers the molecules process by process, as each has them.
class SharedBody {
 public:
  SharedBody(const Body& whole, MPI_Comm communicator);

  const Subdomain& own() const { return own_; }
  int size() const { return static_cast<int>(own_.molecules.size()); }
  int owned() const { return own_.owned; }
  MPI_Comm communicator() const { return communicator_; }
  int processes() const { return static_cast<int>(counts_.size()); }
  /// PETSc's number of each molecule of the subdomain.
  const std::vector<PetscInt>& numbers() const { return numbers_; }

  /// A vector of three numbers for each molecule of the whole.
  Vector make_vector() const;
  /// Values of owned molecules for all of the subdomain.
  void spread(Vec owned, Positions& local) const;
  /// The sums of what all subdomains have for a molecule, for its owner.
  void add_up(const Positions& local, Vec owned) const;
  /// Columns of the whole that are the subdomain's.
  void take(const Positions& whole, Positions& local) const;
  /// Values of owned molecules as columns, and back.
  void read(Vec owned, Positions& columns) const;
  void write(const Positions& columns, Vec owned) const;
  /// Owned columns of all processes, for each of them.
  void gather(const Positions& owned, Positions& whole) const;
  double sum(double own) const;
  bool all(bool own) const;
  double largest(double own) const;

 private:
  MPI_Comm communicator_;
  Subdomain own_;
  std::vector<PetscInt> numbers_;
  std::vector<int> molecule_at_;       ///< of the whole, by PETSc's number
  std::vector<int> counts_, offsets_;  ///< 3 × molecules of each process
  Vector ghosted_;
};

/// A model among processes: its elements, loads and supports, each where it is computed.
class SharedModel {
 public:
  /// `whole` must take part, see StaticEngine::unsuited.
  SharedModel(const Model& whole, const SharedBody& body);

  const SharedBody& body() const { return body_; }
  /// On the subdomain: elasticities that it computes, and the supports of all its molecules. No loads.
  Model& local() { return local_; }
  /// Supports of owned molecules.
  const std::vector<Support>& supports() const { return owned_supports_; }
  /// Takes the fixed components of owned molecules out.
  void keep_free(Vec vector) const;

 private:
  const SharedBody& body_;
  Model local_;
  std::vector<Support> owned_supports_;
};

}  // namespace elastin::petsc

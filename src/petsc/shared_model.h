#pragma once
#include <optional>
#include <vector>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/share.h"
#include "petsc/handles.h"

namespace elastin::petsc {

/// A body among the processes of a communicator: each has a subdomain of the whole, or, where it was given a share of
/// the body alone (Body::share), that. PETSc numbers the molecules process by process, as each has them.
class SharedBody {
 public:
  SharedBody(const Body& given, MPI_Comm communicator);

  /// What was given: the whole, or a share.
  const Body& given() const { return given_; }
  bool of_share() const { return given_.share != nullptr; }
  /// The subdomain of the whole; nothing of a share.
  const Subdomain& own() const { return own_; }
  /// Molecules, connections and cells that this process has.
  const Body& local() const { return of_share() ? given_ : *own_.body; }
  int size() const { return local().size(); }
  int owned() const { return of_share() ? owned_molecules(given_) : own_.owned; }
  /// Number of each molecule in the whole.
  std::int64_t number(int molecule) const {
    return of_share() ? number_in_whole(given_, molecule) : own_.molecules[molecule];
  }
  std::int64_t all_molecules() const { return molecules_of_whole(given_); }
  MPI_Comm communicator() const { return communicator_; }
  int processes() const;
  /// PETSc's number of each molecule of the subdomain.
  const std::vector<PetscInt>& numbers() const { return numbers_; }

  /// A vector of three numbers for each molecule of the whole.
  Vector make_vector() const;
  /// Values of owned molecules for all of the subdomain.
  void spread(Vec owned, Positions& local) const;
  /// Of what is in place for all molecules of a share, the owners' values for the others.
  void spread(Positions& local) const;
  /// Makes of what a subdomain has for a molecule, at its owner, the sums of what all have.
  void add_up(Positions& local) const;
  /// Columns of what was given that are the subdomain's.
  void take(const Positions& given, Positions& local) const;
  /// Values of owned molecules as columns, and back.
  void read(Vec owned, Positions& columns) const;
  void write(const Positions& columns, Vec owned) const;
  /// Owned columns, for all molecules of what was given.
  void gather(const Positions& owned, Positions& given) const;
  double sum(double own) const;
  double largest(double own) const;

 private:
  void number_whole();
  MPI_Comm communicator_;
  const Body& given_;
  Subdomain own_;
  std::vector<PetscInt> numbers_;
  std::vector<int> molecule_at_;       ///< of the whole, by PETSc's number
  std::vector<int> counts_, offsets_;  ///< 3 × molecules of each process
  Vector ghosted_;
};

/// A model among processes: its elements, loads and supports, each where it is computed.
class SharedModel {
 public:
  /// What is solved: an equilibrium, by elements each of which one process computes; or the end of a step in time of a
  /// model with complete rows, by these.
  enum class Use { equilibrium, step };
  /// `given`, of the whole or of a share, must take part, see StaticEngine::unsuited, and outlive it.
  SharedModel(Model& given, const SharedBody& body, Use use = Use::equilibrium);

  const SharedBody& body() const { return body_; }
  /// On the subdomain: elasticities that it computes, and the supports of all its molecules. No loads, but of a step.
  Model& local() { return subdomain_ ? *subdomain_ : given_; }
  /// Supports of owned molecules.
  const std::vector<Support>& supports() const { return owned_supports_; }
  bool of_step() const { return use_ == Use::step; }
  /// What has to be added for owned molecules: what all processes have for them, or, of complete rows, what is there.
  void collect(Positions& local, Vec owned) const {
    if (!of_step()) body_.add_up(local);
    body_.write(local, owned);
  }
  /// Takes the fixed components of owned molecules out.
  void keep_free(Vec vector) const;

 private:
  const SharedBody& body_;
  Model& given_;
  Use use_;
  std::optional<Model> subdomain_;  ///< of a whole, or next to complete rows
  std::vector<Support> owned_supports_;
};

}  // namespace elastin::petsc

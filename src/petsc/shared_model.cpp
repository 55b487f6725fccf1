#include "petsc/shared_model.h"

namespace elastin::petsc {

SharedBody::SharedBody(const Body& given, MPI_Comm communicator) : communicator_(communicator), given_(given) {
  if (of_share())
    numbers_.assign(given.share->place.begin(), given.share->place.end());
  else
    number_whole();
  check(VecCreateGhostBlock(communicator_, 3, 3 * owned(), PETSC_DETERMINE, size() - owned(), numbers_.data() + owned(),
                            ghosted_.out()));
}

int SharedBody::processes() const {
  int processes = 1;
  MPI_Comm_size(communicator_, &processes);
  return processes;
}

void SharedBody::number_whole() {
  int rank = 0;
  MPI_Comm_rank(communicator_, &rank);
  const int processes = this->processes();
  const std::vector<int> owners = bisect(given_.rest, processes);
  own_ = make_subdomain(given_, owners, rank);
  counts_.assign(processes, 0);
  for (const int owner : owners) counts_[owner] += 3;
  offsets_.assign(counts_.size(), 0);
  for (std::size_t i = 1; i < counts_.size(); ++i) offsets_[i] = offsets_[i - 1] + counts_[i - 1];
  std::vector<int> next = offsets_, number_of(owners.size());
  molecule_at_.resize(owners.size());
  for (std::size_t molecule = 0; molecule < owners.size(); ++molecule) {
    int& at = next[owners[molecule]];
    number_of[molecule] = at / 3;
    molecule_at_[at / 3] = static_cast<int>(molecule);
    at += 3;
  }
  for (const int molecule : own_.molecules) numbers_.push_back(number_of[molecule]);
}

Vector SharedBody::make_vector() const {
  Vector vector;
  check(VecCreateMPI(communicator_, 3 * owned(), PETSC_DETERMINE, vector.out()));
  check(VecSetBlockSize(vector, 3));
  return vector;
}

namespace {

/// The numbers of a vector stand elsewhere for a while.
class Placed {
 public:
  Placed(Vec vector, Positions& columns) : vector_(vector) { check(VecPlaceArray(vector, columns.data())); }
  ~Placed() { VecResetArray(vector_); }
  Placed(const Placed&) = delete;
  Placed& operator=(const Placed&) = delete;

 private:
  Vec vector_;
};

}  // namespace

void SharedBody::spread(Vec owned_values, Positions& local) const {
  local.resize(3, size());
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(owned_values, &values));
  local.leftCols(owned()) = Eigen::Map<const Positions>(values, 3, owned());
  check(VecRestoreArrayRead(owned_values, &values));
  spread(local);
}

void SharedBody::spread(Positions& local) const {
  const Placed placed(ghosted_, local);
  check(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  check(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
}

void SharedBody::add_up(Positions& local) const {
  const Placed placed(ghosted_, local);
  check(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  check(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
}

void SharedBody::take(const Positions& given, Positions& local) const {
  if (of_share()) {
    local = given;
    return;
  }
  local.resize(3, size());
  for (int i = 0; i < size(); ++i) local.col(i) = given.col(own_.molecules[i]);
}

void SharedBody::read(Vec owned_values, Positions& columns) const {
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(owned_values, &values));
  columns = Eigen::Map<const Positions>(values, 3, owned());
  check(VecRestoreArrayRead(owned_values, &values));
}

void SharedBody::write(const Positions& columns, Vec owned_values) const {
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(owned_values, &values));
  Eigen::Map<Positions>(values, 3, owned()) = columns.leftCols(owned());
  check(VecRestoreArrayWrite(owned_values, &values));
}

void SharedBody::gather(const Positions& owned_columns, Positions& given) const {
  if (of_share()) {
    const Vector vector = make_vector();
    write(owned_columns, vector);
    return spread(vector, given);
  }
  const auto count = static_cast<Eigen::Index>(molecule_at_.size());
  Positions ordered(3, count);
  MPI_Allgatherv(owned_columns.data(), 3 * owned(), MPI_DOUBLE, ordered.data(), counts_.data(), offsets_.data(),
                 MPI_DOUBLE, communicator_);
  given.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) given.col(molecule_at_[i]) = ordered.col(i);
}

double SharedBody::sum(double own) const {
  double total = 0;
  MPI_Allreduce(&own, &total, 1, MPI_DOUBLE, MPI_SUM, communicator_);
  return total;
}

double SharedBody::largest(double own) const {
  double result = 0;
  MPI_Allreduce(&own, &result, 1, MPI_DOUBLE, MPI_MAX, communicator_);
  return result;
}

SharedModel::SharedModel(Model& given, const SharedBody& body, Use use) : body_(body), given_(given), use_(use) {
  if (!body.of_share() || (given.has_complete_rows() && use == Use::equilibrium)) {
    subdomain_.emplace(body.local());
    for (const auto& term : given.elasticity())
      subdomain_->add(body.of_share() ? term->clone() : term->on_subdomain(body.own()));
  }
  for (const Support& support : given.supports) {
    const int molecule = body.of_share() ? support.molecule : body.own().local(support.molecule);
    if (molecule < 0) continue;
    Support own = support;
    own.molecule = molecule;
    if (subdomain_) subdomain_->supports.push_back(own);
    if (molecule < body.owned()) owned_supports_.push_back(own);
  }
}

void SharedModel::keep_free(Vec vector) const {
  PetscScalar* values = nullptr;
  check(VecGetArray(vector, &values));
  Eigen::Map<Positions> columns(values, 3, body_.owned());
  for (const Support& support : owned_supports_)
    columns.col(support.molecule) = (support.free * columns.col(support.molecule)).eval();
  check(VecRestoreArray(vector, &values));
}

}  // namespace elastin::petsc

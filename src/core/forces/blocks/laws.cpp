#include "elastin/core/forces/block_cells.h"

namespace elastin {
namespace {

/// The law at work in each cell of a block, or once where all cells have the same.
template <class AtWork>
auto laws_of(const Body& body, const CellBlock& block, const Material& material, const AtWork& at_work) {
  std::vector<decltype(at_work(material))> laws;
  Material own = material;
  for (int cell = 0; cell < (block.stiffness.size() || material.varies() ? block.size() : 1); ++cell) {
    if (material.varies()) own = local_material(material, middle_of(body, block, cell));
    if (block.stiffness.size()) own.youngs_modulus = material.youngs_modulus * block.stiffness[cell];
    laws.push_back(at_work(own));
  }
  return laws;
}

/// Of all points of a cell one law: one for all cells, or one a cell.
template <int dimensions>
class CellLaws final : public PointLaws<dimensions> {
 public:
  explicit CellLaws(std::vector<AnyPoint<dimensions>> laws) : laws_(std::move(laws)) {}

  bool has_energy() const override { return laws_.front().has_energy(); }
  void stresses(int cell, std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const override {
    of(cell).stresses(A, S);
  }
  void tangents(int cell, std::span<const Tensor<dimensions>> A,
                std::span<TangentModuli<dimensions>> D) const override {
    of(cell).tangents(A, D);
  }
  double energy(int cell, std::span<const Tensor<dimensions>> A, std::span<const double> weights) const override {
    return of(cell).energy(A, weights);
  }

 private:
  const AnyPoint<dimensions>& of(int cell) const {
    return laws_[laws_.size() == 1 ? 0 : static_cast<std::size_t>(cell)];
  }
  std::vector<AnyPoint<dimensions>> laws_;
};

}  // namespace

template <int dimensions>
std::unique_ptr<NodalForces> make_block_cells(const Body& body, const CellBlock& block,
                                              std::vector<AnyPoint<dimensions>> laws, std::vector<Volumetric> volume) {
  return make_block_cells<dimensions>(body, block, std::make_shared<const CellLaws<dimensions>>(std::move(laws)),
                                      std::move(volume));
}
template std::unique_ptr<NodalForces> make_block_cells<2>(const Body&, const CellBlock&, std::vector<AnyPoint<2>>,
                                                          std::vector<Volumetric>);
template std::unique_ptr<NodalForces> make_block_cells<3>(const Body&, const CellBlock&, std::vector<AnyPoint<3>>,
                                                          std::vector<Volumetric>);

namespace {

/// A law for each block of cells of these dimensions.
template <class Make>
ElasticTerms for_each_block(const Body& body, int dimensions, const Make& make) {
  ElasticTerms all;
  for (const CellBlock& block : body.blocks)
    if (block.kind->dimensions == dimensions) all.add(make(block));
  return all;
}

}  // namespace

template <int dimensions>
ElasticTerms make_blocks(const Body& body, const Material& material, const AnyAtWork<dimensions>& at_work) {
  return for_each_block(body, dimensions, [&](const CellBlock& block) {
    return make_block_cells<dimensions>(body, block, laws_of(body, block, material, at_work));
  });
}
template ElasticTerms make_blocks<2>(const Body&, const Material&, const AnyAtWork<2>&);
template ElasticTerms make_blocks<3>(const Body&, const Material&, const AnyAtWork<3>&);

ElasticTerms make_mixed_blocks(const Body& body, const Material& material,
                               const std::function<SplitPoint<AnyPoint<3>>(const Material&)>& at_work) {
  return for_each_block(body, 3, [&](const CellBlock& block) {
    std::vector<AnyPoint<3>> shapes;
    std::vector<Volumetric> volumes;
    for (auto& [shape, volume] : laws_of(body, block, material, at_work))
      shapes.push_back(std::move(shape)), volumes.push_back(volume);
    return make_block_cells<3>(body, block, std::move(shapes), std::move(volumes));
  });
}

}  // namespace elastin

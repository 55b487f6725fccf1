#pragma once
#include <memory>
#include <string>

#include "elastin/core/forces/elasticity.h"

namespace elastin {

/// A law whose stress relaxes, quasi-linear: of each connection's elastic force density qᵉ
///   q(t) = ∫ G(t − s) dqᵉ(s),  G = g₀ + Σ gᵢ e^(−t/τᵢ).
/// q is linear in S with constant gradients, so that springs and cells relax alike. Over a step Δ, qᵉ linear in it,
///   Qᵢ ← e^(−Δ/τᵢ) Qᵢ + hᵢ (qᵉ_new − qᵉ_old),  hᵢ = (1 − e^(−Δ/τᵢ)) τᵢ/Δ,  q = g₀ qᵉ + Σ gᵢ Qᵢ,
/// which is exact. [Taylor, Pister & Goudreau 1970] Within a step q = (g₀ + Σ gᵢ hᵢ) qᵉ + r has an energy, r fixed.
/// Statics sees g₀ alone. The body must outlive it.
/// Throws InputError where the law finds its forces at the nodes of cells, or where shares or times are not positive,
/// or take all of the stiffness.
ElasticTerms make_prony(const Body& body, ElasticTerms elastic, const Relaxation& relaxation);

/// Throws InputError as make_prony does.
void check_relaxation(const Relaxation& relaxation);

}  // namespace elastin

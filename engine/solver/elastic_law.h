// One law of elasticity: which kernels it runs in the order of a solve, and what it asks of the plan. Each
// has a file of its own, law_<name>.cpp; Elasticity and the plan go through the ones that a scene has.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/spec.h"

#include <memory>

namespace pliant {

struct Scene;
struct SimulationState;

/// What a law's kernels work on. All of it must outlive the law.
struct LawContext {
  Device& device;
  const Scene& scene;
  const Model& model;
  SimulationState& state;
  std::uint32_t particles = 0; ///< row length of `shape`
  double unit = 0;             ///< m, of packed bond vectors
  std::uint32_t share_row = 0; ///< of `shape`: share of the weights that is left; 0: nothing breaks
};

class ElasticLaw {
public:
  explicit ElasticLaw(const LawContext& context) : context_(context) {}
  virtual ~ElasticLaw() = default;
  ElasticLaw(const ElasticLaw&) = delete;
  ElasticLaw& operator=(const ElasticLaw&) = delete;

  /// Once: constants of a range beyond the two rows of `shape` that all laws have.
  virtual void upload(const LawRange&) {}
  /// The functions of Elasticity, for one range of particles.
  virtual void begin(const LawRange&) {}
  virtual void state(const LawRange& range, BufferStorage* displacement) = 0;
  virtual void force(const LawRange& range) = 0;
  virtual void energy(const LawRange& range, BufferStorage* displacement, bool gated) = 0;
  virtual void tangent(const LawRange&, BufferStorage*) {}
  virtual void product(const LawRange&, BufferStorage*) {}

protected:
  LawContext context_;
};

/// What the plan knows when it asks.
struct LawRequest {
  const Scene& scene;
  const Model& model;
  const SlicedBonds& bonds;
  bool derivative = false; ///< Newton's method: tangents and products
  bool potential = false;  ///< energies in the line search
  bool failing = false;    ///< bonds may break
};

/// Names of components are the plan's business and stay empty.
struct LawNeeds {
  std::size_t shape_rows = 2; ///< of `shape`: 1 / (modulus V), 1/J; coupling; then the law's own
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels, energies;
  template <class Args> void kernel(const Args& args) { kernels.push_back(kernel_variant(args, "")); }
  /// An energy at the end of a step and, with a potential, where the line search looks at it.
  template <class Args> void energy(const LawRequest& request) {
    for (const std::uint32_t gated : {0u, 1u})
      if (!gated || request.potential) energies.push_back(kernel_variant(Args{.gated = gated}, ""));
  }
};

/// Those that this build has, in the order of particles.
std::span<const Law> elastic_laws();
std::unique_ptr<ElasticLaw> make_law(Law law, const LawContext& context);
LawNeeds law_needs(Law law, const LawRequest& request);

std::unique_ptr<ElasticLaw> make_corotated(const LawContext& context);
std::unique_ptr<ElasticLaw> make_ordinary(const LawContext& context);
std::unique_ptr<ElasticLaw> make_projective(const LawContext& context);
std::unique_ptr<ElasticLaw> make_basis(const LawContext& context);
std::unique_ptr<ElasticLaw> make_neo_hookean(const LawContext& context);
LawNeeds corotated_needs(const LawRequest& request);
LawNeeds ordinary_needs(const LawRequest& request);
LawNeeds projective_needs(const LawRequest& request);
LawNeeds basis_needs(const LawRequest& request);
LawNeeds neo_hookean_needs(const LawRequest& request);

} // namespace pliant

// The multilevel preconditioner: z = D^-1 r + P V(P^T r), V one V(1,1) cycle of damped block Jacobi over the
// coarse levels (engine/model/hierarchy.h), whose matrices follow the rotations and the obstacles' contacts
// of the iterate. Symmetric and positive definite, so that conjugate gradients may use it.
#pragma once

#include "engine/model/hierarchy.h"
#include "engine/plan/spec.h"
#include "engine/solver/preconditioner.h"

#include <map>

namespace pliant {

struct ContactPlan;

struct MultilevelPlan {
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels;
};
MultilevelPlan plan_multilevel(const Hierarchy& hierarchy, const Model& model, const ContactPlan& contacts);

/// Whether neighbourhoods of a law over basis functions, which has no rotation, get one for the coarse
/// elements. The ordinary law does without: bodies that start collapsed then come back on other paths.
bool turns_bonds(const LawRange& range);
bool turns_bonds(const Model& model);

class Multilevel : public Preconditioner {
public:
  explicit Multilevel(const SolveContext& context);
  void begin(const SolveBounds& bounds) override { bounds_ = bounds; }
  void refresh() override;
  void apply() override;

private:
  BufferStorage* at(const std::string& name) const;
  void restrict_to(std::size_t level, BufferStorage* source);
  void sweep(const HierarchyLevel& level, bool relaxed);

  const Hierarchy& hierarchy_;
  std::map<std::string, Buffer> buffers_;
  bool rotated_ = false, obstacles_ = false;
  SolveBounds bounds_;
};

} // namespace pliant

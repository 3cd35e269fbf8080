// The table of bodies of one instruction set. Compiled without that set: only the bodies themselves use it.
#include "backends/openmp/table.h"

#include "kernels/all.h"

namespace pliant::openmp::PLIANT_ISA {

#define PLIANT_KERNEL(kernel) template <class real> void kernel(const kernels::kernel::View<real>&);
#include "kernels/all.inc"
#undef PLIANT_KERNEL

Body find(std::string_view name, Precision precision) {
#define PLIANT_KERNEL(kernel)                                                                                \
  if (name == #kernel) {                                                                                     \
    if (precision == Precision::double_precision)                                                            \
      return [](const void* args, Data data) {                                                               \
        PLIANT_ISA::kernel(                                                                                  \
            kernels::kernel::make_view<double>(*static_cast<const kernels::kernel::Args*>(args), data));     \
      };                                                                                                     \
    return [](const void* args, Data data) {                                                                 \
      PLIANT_ISA::kernel(                                                                                    \
          kernels::kernel::make_view<float>(*static_cast<const kernels::kernel::Args*>(args), data));        \
    };                                                                                                       \
  }
#include "kernels/all.inc"
#undef PLIANT_KERNEL
  return nullptr;
}

} // namespace pliant::openmp::PLIANT_ISA

// What every CPU body includes. A body is compiled once for each instruction set (PLIANT_ISA names its
// namespace) and instantiated for float and double; the device picks the widest set that the processor has.
// Bodies stay free of the standard library's inline functions: a copy compiled for a wide instruction set
// must never be the one that the linker keeps for everybody.
#pragma once

#include "kernels/kernel.h"

#define PLIANT_BODY(kernel)                                                                                  \
  template void kernel<float>(const ::pliant::kernels::kernel::View<float>&);                                \
  template void kernel<double>(const ::pliant::kernels::kernel::View<double>&);

// Reads PLIANT_DECL four times and writes the C++ side of one kernel. No include guard: once a kernel.
#include "kernels/kernel.h"

// 1: Args, as the engine fills them in.
#define KERNEL_BEGIN(kernel, group)                                                                          \
  namespace pliant::kernels::kernel {                                                                        \
  inline constexpr const char* kernel_name = #kernel;                                                        \
  inline constexpr std::uint32_t group_size = group;                                                         \
  struct Args {                                                                                              \
    std::uint32_t threads = 0;
#define KERNEL_OPTION(name) std::uint32_t name = 0;
#define KERNEL_PARAM(type, name) ::pliant::argument::type name = 0;
#define KERNEL_TABLE(slot, type, name, size) ::pliant::BufferStorage* name = nullptr;
#define KERNEL_IN(slot, type, name) ::pliant::BufferStorage* name = nullptr;
#define KERNEL_OUT(slot, type, name) ::pliant::BufferStorage* name = nullptr;
#define KERNEL_INOUT(slot, type, name) ::pliant::BufferStorage* name = nullptr;
#define KERNEL_END(kernel)                                                                                   \
  static const ::pliant::KernelInfo& info();                                                                 \
  }                                                                                                          \
  ;                                                                                                          \
  }
#include PLIANT_DECL
#include "kernels/expand_end.h"

// 2: the fields, for devices.
#define PLIANT_FIELD(name, type, role, slot, size)                                                           \
  {#name, ::pliant::Type::type, ::pliant::Role::role, slot, size, offsetof(Args, name)},
#define KERNEL_BEGIN(kernel, group)                                                                          \
  namespace pliant::kernels::kernel {                                                                        \
  inline constexpr ::pliant::Field fields[] = {
#define KERNEL_OPTION(name) PLIANT_FIELD(name, uint, option, 0, 0)
#define KERNEL_PARAM(type, name) PLIANT_FIELD(name, type, parameter, 0, 0)
#define KERNEL_TABLE(slot, type, name, size) PLIANT_FIELD(name, type, table, slot, size)
#define KERNEL_IN(slot, type, name) PLIANT_FIELD(name, type, in, slot, 0)
#define KERNEL_OUT(slot, type, name) PLIANT_FIELD(name, type, out, slot, 0)
#define KERNEL_INOUT(slot, type, name) PLIANT_FIELD(name, type, inout, slot, 0)
#define KERNEL_END(kernel)                                                                                   \
  }                                                                                                          \
  ;                                                                                                          \
  inline constexpr ::pliant::KernelInfo kernel_info{kernel_name, group_size, fields};                        \
  inline const ::pliant::KernelInfo& Args::info() {                                                          \
    return kernel_info;                                                                                      \
  }                                                                                                          \
  }
#include PLIANT_DECL
#include "kernels/expand_end.h"
#undef PLIANT_FIELD

// 3: View, as a CPU body sees it.
#define KERNEL_BEGIN(kernel, group)                                                                          \
  namespace pliant::kernels::kernel {                                                                        \
  template <class real_type> struct View {                                                                   \
    using real = real_type;                                                                                  \
    using real4 = ::pliant::Real4<real>;                                                                     \
    using uint = std::uint32_t;                                                                              \
    using uint4 = ::pliant::Uint4;                                                                           \
    uint threads;
#define KERNEL_OPTION(name) uint name;
#define KERNEL_PARAM(type, name) type name;
#define KERNEL_TABLE(slot, type, name, size) const type* __restrict name;
#define KERNEL_IN(slot, type, name) const type* __restrict name;
#define KERNEL_OUT(slot, type, name) type* __restrict name;
#define KERNEL_INOUT(slot, type, name) type* __restrict name;
#define KERNEL_END(kernel)                                                                                   \
  }                                                                                                          \
  ;                                                                                                          \
  }
#include PLIANT_DECL
#include "kernels/expand_end.h"

// 4: from Args to View. `data(buffer)` gives a buffer's memory.
#define KERNEL_BEGIN(kernel, group)                                                                          \
  namespace pliant::kernels::kernel {                                                                        \
  template <class real, class Data> View<real> make_view(const Args& args, Data data) {                      \
    using V = View<real>;                                                                                    \
    (void)data;                                                                                              \
    V view{};                                                                                                \
    view.threads = args.threads;
#define KERNEL_OPTION(name) view.name = args.name;
#define KERNEL_PARAM(type, name) view.name = static_cast<typename V::type>(args.name);
#define KERNEL_TABLE(slot, type, name, size)                                                                 \
  view.name = static_cast<const typename V::type*>(data(args.name));
#define KERNEL_IN(slot, type, name) view.name = static_cast<const typename V::type*>(data(args.name));
#define KERNEL_OUT(slot, type, name) view.name = static_cast<typename V::type*>(data(args.name));
#define KERNEL_INOUT(slot, type, name) view.name = static_cast<typename V::type*>(data(args.name));
#define KERNEL_END(kernel)                                                                                   \
  return view;                                                                                               \
  }                                                                                                          \
  }
#include PLIANT_DECL
#include "kernels/expand_end.h"

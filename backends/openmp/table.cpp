// Picks the instruction set once, for the whole process.
#include "backends/openmp/table.h"

#include "backends/openmp/device.h"

#include <cstdlib>
#include <string>

namespace pliant::openmp {

namespace baseline {
Body find(std::string_view name, Precision precision);
}
#ifdef PLIANT_WITH_X86_CLONES
namespace isa_v3 {
Body find(std::string_view name, Precision precision);
}
namespace isa_v4 {
Body find(std::string_view name, Precision precision);
}
#endif

namespace {

struct Choice {
  Lookup find;
  const char* name;
};

// PLIANT_ISA in the environment narrows the choice, so that each clone can be tested on one machine.
Choice choose() {
#ifdef PLIANT_WITH_X86_CLONES
  const char* wanted = std::getenv("PLIANT_ISA");
  const std::string limit = wanted ? wanted : "x86-64-v4";
  if (limit == "x86-64-v4" && __builtin_cpu_supports("x86-64-v4")) return {isa_v4::find, "x86-64-v4"};
  if (limit != "baseline" && __builtin_cpu_supports("x86-64-v3")) return {isa_v3::find, "x86-64-v3"};
#endif
  return {baseline::find, "baseline"};
}

const Choice& choice() {
  static const Choice chosen = choose();
  return chosen;
}

} // namespace

Body find_body(std::string_view kernel, Precision precision) {
  return choice().find(kernel, precision);
}

const char* instruction_set() {
  return choice().name;
}

} // namespace pliant::openmp

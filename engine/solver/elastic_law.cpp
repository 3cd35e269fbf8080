// The laws by name.
#include "engine/solver/elastic_law.h"

#include "engine/core/error.h"

#include <fmt/core.h>

#include <array>

namespace pliant {

namespace {

struct Entry {
  Law law;
  std::unique_ptr<ElasticLaw> (*make)(const LawContext&);
  LawNeeds (*needs)(const LawRequest&);
};

constexpr std::array entries{
    Entry{Law::corotated, make_corotated, corotated_needs},
    Entry{Law::ordinary, make_ordinary, ordinary_needs},
    Entry{Law::projective, make_projective, projective_needs},
    Entry{Law::basis, make_basis, basis_needs},
    Entry{Law::neo_hookean, make_neo_hookean, neo_hookean_needs},
};

constexpr auto all = [] {
  std::array<Law, entries.size()> laws{};
  for (std::size_t k = 0; k < laws.size(); ++k) laws[k] = entries[k].law;
  return laws;
}();

const Entry& entry_of(Law law) {
  for (const Entry& entry : entries)
    if (entry.law == law) return entry;
  throw Error(ExitCode::internal, fmt::format("no kernels are known for the law '{}'", law_name(law)));
}

} // namespace

std::span<const Law> elastic_laws() {
  return all;
}

std::unique_ptr<ElasticLaw> make_law(Law law, const LawContext& context) {
  return entry_of(law).make(context);
}

LawNeeds law_needs(Law law, const LawRequest& request) {
  return entry_of(law).needs(request);
}

} // namespace pliant

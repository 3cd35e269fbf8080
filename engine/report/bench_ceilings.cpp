// Ceilings by small loops that do nothing else.
#include "engine/report/bench_ceilings.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

namespace pliant {

namespace {

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__)
#define PLIANT_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define PLIANT_CLONES
#endif

using Clock = std::chrono::steady_clock;

constexpr std::size_t l2_bytes = std::size_t{256} << 10; ///< a thread: half of the smallest L2 in use
constexpr std::size_t l3_bytes = std::size_t{8} << 20;   ///< all threads
constexpr std::size_t memory_bytes = std::size_t{256} << 20;

double seconds(Clock::time_point since) {
  return std::chrono::duration<double>(Clock::now() - since).count();
}

/// The sum of a multiple of 64 floats in 64 running sums: as fast as loads go.
PLIANT_CLONES float read_all(const float* values, std::size_t count) {
  float sum[64] = {};
  for (std::size_t i = 0; i < count; i += 64)
    for (std::size_t k = 0; k < 64; ++k) sum[k] += values[i + k];
  float total = 0;
  for (const float part : sum) total += part;
  return total;
}

/// 2 * 96 * rounds floating-point operations in 96 independent chains.
PLIANT_CLONES float multiply_add(std::size_t rounds, float factor) {
  float value[96];
  for (std::size_t k = 0; k < 96; ++k) value[k] = static_cast<float>(k);
  for (std::size_t round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < 96; ++k) value[k] = value[k] * factor + 0.5F;
  float total = 0;
  for (const float part : value) total += part;
  return total;
}

/// Shortest time of `work(thread)` on all threads together, s.
template <class Work> double best_time(unsigned threads, int tries, const Work& work) {
  double best = 1e30;
  for (int attempt = 0; attempt < tries; ++attempt) {
    std::vector<std::thread> team;
    const auto start = Clock::now();
    for (unsigned t = 1; t < threads; ++t) team.emplace_back([&work, t] { work(t); });
    work(0);
    for (std::thread& member : team) member.join();
    best = std::min(best, seconds(start));
  }
  return best;
}

double read_rate(unsigned threads, std::size_t bytes_each, std::size_t passes) {
  const std::size_t count = bytes_each / sizeof(float) / 64 * 64;
  std::vector<std::vector<float>> values(threads, std::vector<float>(count, 1.0F));
  std::vector<float> keep(threads);
  const double time = best_time(threads, 12, [&](unsigned t) {
    for (std::size_t pass = 0; pass < passes; ++pass) keep[t] += read_all(values[t].data(), count);
  });
  return static_cast<double>(threads * passes * count * sizeof(float)) / time / 1e9;
}

} // namespace

double Ceilings::bandwidth(double bytes) const {
  if (copy > 0) return copy;
  if (bytes <= 2.0 * l2_bytes) return read_l2;
  return bytes <= 2.0 * l3_bytes ? read_l3 : read_memory;
}

Ceilings measure_ceilings(Device& device) {
  Ceilings ceilings;
  if (device.info().backend == "openmp") {
    const unsigned threads = std::max(device.info().threads, 1U);
    ceilings.read_l2 = read_rate(threads, l2_bytes, 400);
    ceilings.read_l3 = read_rate(threads, l3_bytes / threads, 20);
    ceilings.read_memory = read_rate(threads, memory_bytes / threads, 1);
    constexpr std::size_t rounds = 2000000;
    std::vector<float> keep(threads);
    const double time = best_time(threads, 3, [&](unsigned t) { keep[t] = multiply_add(rounds, 0.999F); });
    ceilings.fma = 2.0 * 96 * rounds * threads / time / 1e9;
    return ceilings;
  }
  constexpr std::size_t bytes = std::size_t{64} << 20;
  const Buffer from = device.allocate("bench_from", Type::real4, bytes / 16);
  const Buffer to = device.allocate("bench_to", Type::real4, bytes / 16);
  double best = 1e30;
  for (int attempt = 0; attempt < 5; ++attempt) {
    device.finish();
    const auto start = Clock::now();
    device.copy(from, to);
    device.finish();
    best = std::min(best, seconds(start));
  }
  ceilings.copy = 2.0 * bytes / best / 1e9;
  return ceilings;
}

} // namespace pliant

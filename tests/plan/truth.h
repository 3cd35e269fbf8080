// A plan beside what its simulation really allocates, compiles and runs.
#pragma once

#include "engine/plan/plan_report.h"
#include "engine/solver/frame.h"
#include "engine/solver/simulation.h"
#include "tests/plan/scenes.h"
#include "tests/support/devices.h"
#include "tests/support/recording_device.h"

#include <gtest/gtest.h>

namespace pliant::test {

using Names = std::set<std::string>;

class PlanTruth : public testing::TestWithParam<DeviceChoice> {};

inline Names variants(const Plan& plan) {
  Names names;
  for (const KernelSpec& kernel : plan.kernels) names.insert(variant_name(kernel));
  return names;
}

inline Names kernels_of(const Plan& plan) {
  Names names;
  for (const KernelSpec& kernel : plan.kernels) names.insert(kernel.info->name);
  return names;
}

inline Names difference(const Names& a, const Names& b) {
  Names only;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::inserter(only, only.begin()));
  return only;
}

inline std::string text_of(const Names& names) {
  std::string text;
  for (const std::string& name : names) text += " " + name;
  return text;
}

struct Truth {
  Plan plan;
  Names allocated, dispatched, used, missing;
};

// Builds the scene on a fresh device and runs it past a rebase, comparing plan and truth.
inline Truth expect_truth(const DeviceChoice& choice, const PlanScene& made, const std::string& what) {
  SCOPED_TRACE(what);
  const std::unique_ptr<Device> device = choice.open();
  const std::size_t bytes_before = device->bytes_allocated();
  RecordingDevice recorder(*device);
  Truth truth;
  {
    Simulation simulation(recorder, made.scene, made.model, made.request);
    truth.plan = simulation.plan();
    const std::vector<std::string> compiled = device->kernels_prepared();
    EXPECT_EQ(recorder.prepared, variants(truth.plan));
    EXPECT_EQ(Names(compiled.begin(), compiled.end()),
              choice.gl() ? variants(truth.plan) : kernels_of(truth.plan));
    for (int step = 0; step < 33; ++step) {
      simulation.step();
      if (step == 1 && simulation.frame()) simulation.frame()->update();
      if (step == 1 && truth.plan.divergence) simulation.keep();
    }
    device->finish();
    EXPECT_EQ(device->kernels_prepared(), compiled) << "a step compiled a kernel";
    EXPECT_EQ(recorder.bytes_allocated(), truth.plan.bytes(choice.precision));
  }
  EXPECT_EQ(device->bytes_allocated(), bytes_before) << "a simulation leaves memory behind";
  EXPECT_FALSE(recorder.twice) << "two buffers of one name";
  Names planned;
  for (const BufferSpec& buffer : truth.plan.buffers) {
    planned.insert(buffer.name);
    const auto found = recorder.allocated.find(buffer.name);
    if (found != recorder.allocated.end()) {
      EXPECT_EQ(found->second, buffer.count * element_bytes(buffer.type, choice.precision)) << buffer.name;
    }
  }
  for (const auto& [name, bytes] : recorder.allocated) truth.allocated.insert(name);
  truth.dispatched = recorder.dispatched;
  truth.used = recorder.used;
  EXPECT_EQ(truth.allocated, planned);
  EXPECT_EQ(truth.dispatched, variants(truth.plan))
      << "never run:" << text_of(difference(variants(truth.plan), truth.dispatched));
  EXPECT_EQ(truth.used, planned) << "never used:" << text_of(difference(planned, truth.used));
  EXPECT_TRUE(recorder.missing.empty()) << "used without being given:" << text_of(recorder.missing);
  return truth;
}

} // namespace pliant::test

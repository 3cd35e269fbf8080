// Contexts without a display, several in a process, and beside a host that has its own.
#include "backends/gl/egl.h"
#include "kernels/predict.h"
#include "tests/support/devices.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

namespace pliant::test {
namespace {

using gl::Context;
using gl::Current;
using gl::ThreadState;

// Two particles falling for one step: a device that works gives h^2 g.
void expect_work(Device& device) {
  const Buffer velocity = device.allocate("velocity", Type::real4, 2),
               position = device.allocate("y", Type::real4, 2);
  const Buffer target = device.allocate("t", Type::real4, 2), guess = device.allocate("g", Type::real4, 2);
  device.upload(position, std::vector<Real4<double>>(2, {0, 0, 0, 1}));
  kernels::predict::Args args;
  args.threads = 2;
  args.time_step = 0.5;
  args.gravity_y = -8;
  args.position = position;
  args.velocity = velocity;
  args.inertia_target = target;
  args.displacement = guess;
  device.run(args);
  EXPECT_EQ(device.download_real4(target)[1].y, -2);
  EXPECT_EQ(device.download_real4(target)[1].w, 4);
  device.finish();
}

class GlContexts : public testing::Test {
protected:
  void SetUp() override {
    bool present = false;
    for (const DeviceChoice& choice : device_choices()) present |= choice.gl();
    if (!present) GTEST_SKIP() << "no usable GL device";
  }
  void TearDown() override { ThreadState::capture().unbind(); }
};

TEST_F(GlContexts, OpenWithoutADisplay) {
  const unsigned api = ThreadState::capture().egl_api;
  const auto context = Context::open(0);
  EXPECT_FALSE(context->is_current());
  {
    const Current current(*context);
    EXPECT_TRUE(context->is_current());
    GLint major = 0, minor = 0;
    context->gl().GetIntegerv(GL_MAJOR_VERSION, &major);
    context->gl().GetIntegerv(GL_MINOR_VERSION, &minor);
    EXPECT_GE(10 * major + minor, 43);
    EXPECT_FALSE(context->renderer().empty());
  }
  EXPECT_FALSE(context->is_current());
  EXPECT_TRUE(ThreadState::capture().empty());
  EXPECT_EQ(ThreadState::capture().egl_api, api) << "another API is bound on this thread";
}

TEST_F(GlContexts, OfTheSurfacelessPlatform) {
  setenv("PLIANT_GL_CONTEXT", "surfaceless", 1);
  const auto listings = gl::describe_all();
  if (listings.front().usable) {
    const auto device = gl::make_device(0);
    EXPECT_EQ(gl::context_of(*device).kind(), "surfaceless");
    expect_work(*device);
  } else {
    std::printf("[ SKIPPED  ] surfaceless platform: %s\n", listings.front().missing.c_str());
  }
  setenv("PLIANT_GL_CONTEXT", "glx", 1);
  EXPECT_THROW(gl::describe_all(), Error);
  unsetenv("PLIANT_GL_CONTEXT");
}

TEST_F(GlContexts, WorkSideBySide) {
  const auto one = gl::make_device(0), two = gl::make_device(0);
  expect_work(*one);
  expect_work(*two);
  const Buffer a = one->allocate("a", Type::uint, 1), b = two->allocate("b", Type::uint, 1);
  for (std::uint32_t i = 0; i < 3; ++i) {
    one->upload(a, std::vector<std::uint32_t>{i});
    two->upload(b, std::vector<std::uint32_t>{100 + i});
    EXPECT_EQ(one->download_uint(a)[0], i);
    EXPECT_EQ(two->download_uint(b)[0], 100 + i);
  }
}

TEST_F(GlContexts, WorkOnAThreadOfTheirOwn) {
  const auto here = gl::make_device(0);
  expect_work(*here);
  std::thread other([] {
    const auto device = gl::make_device(0);
    for (int i = 0; i < 5; ++i) expect_work(*device);
  });
  for (int i = 0; i < 5; ++i) expect_work(*here);
  other.join();
}

TEST_F(GlContexts, OfOsMesaBesideEgl) {
  if (!gl::OsMesa::load()) GTEST_SKIP() << "libOSMesa is missing (apt install libosmesa6)";
  const auto egl = gl::make_device(0);
  const auto osmesa = gl::make_device(Context::open_osmesa());
  EXPECT_EQ(gl::context_of(*osmesa).kind(), "osmesa");
  EXPECT_TRUE(osmesa->info().software);
  for (int i = 0; i < 3; ++i) {
    expect_work(*osmesa);
    expect_work(*egl);
  }
  {
    const Current outer(gl::context_of(*egl));
    {
      const Current inner(gl::context_of(*osmesa));
      EXPECT_TRUE(gl::context_of(*osmesa).is_current());
      EXPECT_FALSE(gl::context_of(*egl).is_current());
    }
    EXPECT_TRUE(gl::context_of(*egl).is_current());
    expect_work(*egl);
  }
}

TEST_F(GlContexts, ByOsMesaWhenAskedFor) {
  if (!gl::OsMesa::load()) GTEST_SKIP() << "libOSMesa is missing (apt install libosmesa6)";
  setenv("PLIANT_GL_CONTEXT", "osmesa", 1);
  const auto listings = gl::describe_all();
  const auto device = gl::make_device(0);
  unsetenv("PLIANT_GL_CONTEXT");
  ASSERT_EQ(listings.size(), 1u);
  EXPECT_TRUE(listings[0].usable);
  expect_work(*device);
}

// A host's own EGL context, made without Pliant's classes.
class Host {
public:
  Host() : egl_(*gl::Egl::load()) {
    const auto seed = Context::open(0);
    seed->make_current();
    display_ = egl_.current_display();
    egl_.bind_api(gl::Egl::opengl_api);
    const gl::Egl::Int attributes[] = {gl::Egl::context_major, 4,
                                       gl::Egl::context_minor, 3,
                                       gl::Egl::profile_mask,  gl::Egl::core_profile_bit,
                                       gl::Egl::none};
    const gl::Egl::Int wanted[] = {gl::Egl::surface_type, 0, gl::Egl::renderable_type, gl::Egl::opengl_bit,
                                   gl::Egl::none};
    void* config = nullptr;
    gl::Egl::Int count = 0;
    egl_.choose_config(display_, wanted, &config, 1, &count);
    context_ = egl_.create_context(display_, count ? config : nullptr, nullptr, attributes);
    egl_.make_current(display_, nullptr, nullptr, context_);
  }
  ~Host() {
    egl_.make_current(display_, nullptr, nullptr, nullptr);
    egl_.destroy_context(display_, context_);
  }
  bool is_current() const { return context_ && egl_.current_context() == context_; }

private:
  const gl::Egl& egl_;
  void *display_ = nullptr, *context_ = nullptr;
};

void* host_loader(const char* name) {
  return gl::Egl::load()->get_proc_address(name);
}

TEST_F(GlContexts, LeaveTheHostsContextCurrent) {
  if (Context::open(0)->kind() == "osmesa") GTEST_SKIP() << "no EGL here";
  const Host host;
  ASSERT_TRUE(host.is_current());
  auto device = gl::make_device(0);
  EXPECT_TRUE(host.is_current()) << "after opening";
  expect_work(*device);
  EXPECT_TRUE(host.is_current()) << "after a step";
  {
    const Current current(gl::context_of(*device));
    EXPECT_FALSE(host.is_current());
    expect_work(*device);
    EXPECT_FALSE(host.is_current());
  }
  EXPECT_TRUE(host.is_current()) << "after the guard";
  device.reset();
  EXPECT_TRUE(host.is_current()) << "after closing";
}

TEST_F(GlContexts, WorkInTheHostsOwnAndLeaveItsBindings) {
  if (Context::open(0)->kind() == "osmesa") GTEST_SKIP() << "no EGL here";
  const Host host;
  ASSERT_TRUE(host.is_current());
  auto device = gl::make_device(Context::from_current(host_loader));
  const GladGLContext& g = gl::context_of(*device).gl();
  GLuint buffers[5];
  g.GenBuffers(5, buffers);
  for (const GLuint buffer : buffers) {
    g.BindBuffer(GL_COPY_WRITE_BUFFER, buffer);
    g.BufferData(GL_COPY_WRITE_BUFFER, 4096, nullptr, GL_STATIC_DRAW);
  }
  g.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, buffers[0]);
  g.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 4, buffers[1], 256, 512);
  g.BindBufferRange(GL_UNIFORM_BUFFER, 11, buffers[2], 1024, 256);
  g.BindBuffer(GL_COPY_READ_BUFFER, buffers[3]);
  g.BindBuffer(GL_COPY_WRITE_BUFFER, buffers[4]);
  const auto state = [&] {
    std::vector<GLint64> values;
    for (const GLenum name : {GL_CURRENT_PROGRAM, GL_SHADER_STORAGE_BUFFER_BINDING, GL_UNIFORM_BUFFER_BINDING,
                              GL_COPY_READ_BUFFER_BINDING, GL_COPY_WRITE_BUFFER_BINDING}) {
      GLint64 value = 0;
      g.GetInteger64v(name, &value);
      values.push_back(value);
    }
    for (GLuint slot = 0; slot < 12; ++slot)
      for (const GLenum name :
           {GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE,
            GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE}) {
        GLint64 value = 0;
        if (slot < 8 || name == GL_UNIFORM_BUFFER_BINDING || name == GL_UNIFORM_BUFFER_START ||
            name == GL_UNIFORM_BUFFER_SIZE)
          g.GetInteger64i_v(name, slot, &value);
        values.push_back(value);
      }
    return values;
  };
  const auto before = state();
  expect_work(*device);
  EXPECT_EQ(state(), before);
  EXPECT_EQ(g.GetError(), static_cast<GLenum>(GL_NO_ERROR));
  EXPECT_TRUE(host.is_current());
  g.DeleteBuffers(5, buffers);
  const Buffer lent = device->allocate("lent", Type::real4, 3);
  EXPECT_TRUE(g.IsBuffer(gl::gl_name(*static_cast<BufferStorage*>(lent))));
  device.reset();
  EXPECT_TRUE(host.is_current());
}

TEST_F(GlContexts, RefuseADeviceThatIsNotThere) {
  try {
    Context::open(99);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::no_device);
  }
}

TEST(GlNames, BelongToGlBuffersAlone) {
  const auto device = openmp::make_device(Precision::single_precision, 1);
  const Buffer buffer = device->allocate("b", Type::uint, 1);
  EXPECT_THROW(gl::gl_name(*static_cast<BufferStorage*>(buffer)), Error);
  EXPECT_THROW(gl::context_of(*device), Error);
}

} // namespace
} // namespace pliant::test

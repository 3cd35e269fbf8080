// GL objects that delete themselves. Their context must be current whenever they are made, used or destroyed.
#pragma once

#include <glad/gl.h>

#include <utility>

namespace pliant::gl {

/// What kind of object a name belongs to, and how it is made and deleted.
struct BufferKind {
  static void make(const GladGLContext& gl, GLuint* name) { gl.GenBuffers(1, name); }
  static void drop(const GladGLContext& gl, const GLuint* name) { gl.DeleteBuffers(1, name); }
};
struct TextureKind {
  static void make(const GladGLContext& gl, GLuint* name) { gl.GenTextures(1, name); }
  static void drop(const GladGLContext& gl, const GLuint* name) { gl.DeleteTextures(1, name); }
};
struct FramebufferKind {
  static void make(const GladGLContext& gl, GLuint* name) { gl.GenFramebuffers(1, name); }
  static void drop(const GladGLContext& gl, const GLuint* name) { gl.DeleteFramebuffers(1, name); }
};
struct VertexArrayKind {
  static void make(const GladGLContext& gl, GLuint* name) { gl.GenVertexArrays(1, name); }
  static void drop(const GladGLContext& gl, const GLuint* name) { gl.DeleteVertexArrays(1, name); }
};
struct SamplerKind {
  static void make(const GladGLContext& gl, GLuint* name) { gl.GenSamplers(1, name); }
  static void drop(const GladGLContext& gl, const GLuint* name) { gl.DeleteSamplers(1, name); }
};

template <class Kind> class Object {
public:
  explicit Object(const GladGLContext& gl) : gl_(&gl) { Kind::make(gl, &name_); }
  Object(Object&& other) noexcept : gl_(other.gl_), name_(std::exchange(other.name_, 0)) {}
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  ~Object() {
    if (name_) Kind::drop(*gl_, &name_);
  }
  GLuint name() const { return name_; }

private:
  const GladGLContext* gl_;
  GLuint name_ = 0;
};

using GlArray = Object<BufferKind>;
using Texture = Object<TextureKind>;
using Framebuffer = Object<FramebufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Sampler = Object<SamplerKind>;

/// Fills a buffer with `bytes` of data (null: undefined).
inline void fill(const GladGLContext& gl, const GlArray& array, std::size_t bytes, const void* data,
                 GLenum usage) {
  gl.BindBuffer(GL_COPY_WRITE_BUFFER, array.name());
  gl.BufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes > 16 ? bytes : 16), nullptr, usage);
  if (data && bytes) gl.BufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), data);
  gl.BindBuffer(GL_COPY_WRITE_BUFFER, 0);
}

} // namespace pliant::gl

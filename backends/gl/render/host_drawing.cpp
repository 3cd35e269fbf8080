// Reads state in the constructor, writes it back in the destructor.
#include "backends/gl/render/host_drawing.h"

#include <glad/gl.h>

namespace pliant::gl {

namespace {

constexpr std::array<GLenum, 4> targets{GL_TEXTURE_1D, GL_TEXTURE_2D, GL_TEXTURE_BUFFER,
                                        GL_TEXTURE_2D_MULTISAMPLE};
constexpr std::array<GLenum, 4> bindings{GL_TEXTURE_BINDING_1D, GL_TEXTURE_BINDING_2D,
                                         GL_TEXTURE_BINDING_BUFFER, GL_TEXTURE_BINDING_2D_MULTISAMPLE};
constexpr std::array<GLenum, 15> switches{GL_BLEND,
                                          GL_CULL_FACE,
                                          GL_DEPTH_TEST,
                                          GL_DEPTH_CLAMP,
                                          GL_DITHER,
                                          GL_FRAMEBUFFER_SRGB,
                                          GL_MULTISAMPLE,
                                          GL_POLYGON_OFFSET_FILL,
                                          GL_RASTERIZER_DISCARD,
                                          GL_SAMPLE_ALPHA_TO_COVERAGE,
                                          GL_SAMPLE_COVERAGE,
                                          GL_SAMPLE_MASK,
                                          GL_SCISSOR_TEST,
                                          GL_STENCIL_TEST,
                                          GL_COLOR_LOGIC_OP};
constexpr std::array<GLenum, 8> pixel_store{GL_PACK_ALIGNMENT,     GL_PACK_ROW_LENGTH,  GL_PACK_SKIP_ROWS,
                                            GL_PACK_SKIP_PIXELS,   GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH,
                                            GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS};

int integer(const GladGLContext& gl, GLenum name) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return value;
}

void set(const GladGLContext& gl, GLenum name, bool on) {
  if (on)
    gl.Enable(name);
  else
    gl.Disable(name);
}

} // namespace

HostDrawing::HostDrawing(const Context& context) : context_(context) {
  if (!context.wrapped()) return;
  const GladGLContext& gl = context.gl();
  for (const GLenum name : switches) switches_.emplace_back(name, gl.IsEnabled(name) == GL_TRUE);
  active_ = integer(gl, GL_ACTIVE_TEXTURE);
  for (int i = 0; i < units; ++i) {
    gl.ActiveTexture(GL_TEXTURE0 + i);
    for (std::size_t k = 0; k < targets.size(); ++k) unit_[i].textures[k] = integer(gl, bindings[k]);
    unit_[i].sampler = integer(gl, GL_SAMPLER_BINDING);
  }
  for (const GLenum name : pixel_store) pixel_store_.emplace_back(name, integer(gl, name));
  gl.GetIntegerv(GL_VIEWPORT, viewport_.data());
  blend_ = {integer(gl, GL_BLEND_SRC_RGB), integer(gl, GL_BLEND_DST_RGB), integer(gl, GL_BLEND_SRC_ALPHA),
            integer(gl, GL_BLEND_DST_ALPHA)};
  blend_equation_ = {integer(gl, GL_BLEND_EQUATION_RGB), integer(gl, GL_BLEND_EQUATION_ALPHA)};
  gl.GetFloatv(GL_BLEND_COLOR, blend_colour_.data());
  gl.GetFloatv(GL_COLOR_CLEAR_VALUE, clear_colour_.data());
  gl.GetDoublev(GL_DEPTH_CLEAR_VALUE, &clear_depth_);
  gl.GetBooleanv(GL_COLOR_WRITEMASK, colour_mask_.data());
  gl.GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  draw_ = integer(gl, GL_DRAW_FRAMEBUFFER_BINDING);
  read_ = integer(gl, GL_READ_FRAMEBUFFER_BINDING);
  array_ = integer(gl, GL_VERTEX_ARRAY_BINDING);
  array_buffer_ = integer(gl, GL_ARRAY_BUFFER_BINDING);
  pack_ = integer(gl, GL_PIXEL_PACK_BUFFER_BINDING);
  unpack_ = integer(gl, GL_PIXEL_UNPACK_BUFFER_BINDING);
  depth_function_ = integer(gl, GL_DEPTH_FUNC);
  cull_ = integer(gl, GL_CULL_FACE_MODE);
  front_ = integer(gl, GL_FRONT_FACE);
  polygon_ = integer(gl, GL_POLYGON_MODE);

  for (const GLenum name : switches) gl.Disable(name);
  gl.Enable(GL_MULTISAMPLE);
  for (const auto& [name, value] : pixel_store_)
    gl.PixelStorei(name, name == GL_PACK_ALIGNMENT || name == GL_UNPACK_ALIGNMENT ? 4 : 0);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl.BlendEquation(GL_FUNC_ADD);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl.DepthMask(GL_TRUE);
  gl.ClearDepth(1);
  gl.DepthFunc(GL_LESS);
  gl.FrontFace(GL_CCW);
  gl.CullFace(GL_BACK);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

HostDrawing::~HostDrawing() {
  if (!context_.wrapped()) return;
  const GladGLContext& gl = context_.gl();
  for (const auto& [name, on] : switches_) set(gl, name, on);
  for (int i = 0; i < units; ++i) {
    gl.ActiveTexture(GL_TEXTURE0 + i);
    for (std::size_t k = 0; k < targets.size(); ++k) gl.BindTexture(targets[k], unit_[i].textures[k]);
    gl.BindSampler(i, unit_[i].sampler);
  }
  gl.ActiveTexture(active_);
  for (const auto& [name, value] : pixel_store_) gl.PixelStorei(name, value);
  gl.Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  gl.BlendFuncSeparate(blend_[0], blend_[1], blend_[2], blend_[3]);
  gl.BlendEquationSeparate(blend_equation_[0], blend_equation_[1]);
  gl.BlendColor(blend_colour_[0], blend_colour_[1], blend_colour_[2], blend_colour_[3]);
  gl.ClearColor(clear_colour_[0], clear_colour_[1], clear_colour_[2], clear_colour_[3]);
  gl.ClearDepth(clear_depth_);
  gl.ColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
  gl.DepthMask(depth_mask_);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, draw_);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, read_);
  gl.BindVertexArray(array_);
  gl.BindBuffer(GL_ARRAY_BUFFER, array_buffer_);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, pack_);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, unpack_);
  gl.DepthFunc(depth_function_);
  gl.CullFace(cull_);
  gl.FrontFace(front_);
  gl.PolygonMode(GL_FRONT_AND_BACK, polygon_);
}

} // namespace pliant::gl

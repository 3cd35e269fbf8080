// Components timed by GL_TIMESTAMP queries.
#include "backends/gl/timer.h"

#include <glad/gl.h>

namespace pliant::gl {

unsigned Timer::stamp() {
  const GladGLContext& gl = context_.gl();
  GLuint query = 0;
  if (idle_.empty()) {
    gl.GenQueries(1, &query);
  } else {
    query = idle_.back();
    idle_.pop_back();
  }
  gl.QueryCounter(query, GL_TIMESTAMP);
  return query;
}

void Timer::measure(bool on) {
  enter("");
  measuring_ = on;
}

void Timer::enter(std::string_view component) {
  if (!measuring_ || component == component_) return;
  if (!component_.empty()) spans_.push_back({component_, begin_, stamp()});
  component_ = component;
  if (!component_.empty()) begin_ = stamp();
}

std::vector<Timing> Timer::take() {
  const GladGLContext& gl = context_.gl();
  enter("");
  while (!spans_.empty()) {
    const Span& span = spans_.front();
    GLuint arrived = GL_FALSE;
    gl.GetQueryObjectuiv(span.end, GL_QUERY_RESULT_AVAILABLE, &arrived);
    if (!arrived) break;
    GLuint64 begin = 0, end = 0;
    gl.GetQueryObjectui64v(span.begin, GL_QUERY_RESULT, &begin);
    gl.GetQueryObjectui64v(span.end, GL_QUERY_RESULT, &end);
    spent_[span.component] += end > begin ? static_cast<double>(end - begin) * 1e-6 : 0;
    idle_.push_back(span.begin);
    idle_.push_back(span.end);
    spans_.pop_front();
  }
  std::vector<Timing> result;
  for (const auto& [component, milliseconds] : spent_) result.push_back({component, milliseconds});
  spent_.clear();
  return result;
}

void Timer::release() {
  const GladGLContext& gl = context_.gl();
  measure(false);
  for (const Span& span : spans_) {
    idle_.push_back(span.begin);
    idle_.push_back(span.end);
  }
  spans_.clear();
  gl.DeleteQueries(static_cast<GLsizei>(idle_.size()), idle_.data());
  idle_.clear();
}

} // namespace pliant::gl

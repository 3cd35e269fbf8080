// The bar that says which colour is which value.
#pragma once

#include "engine/render/image.h"

#include <string>

namespace pliant::gl {

/// Height of a capital letter of the legend, pixels, in a picture of this height. The legend is some 11 of
/// them wide.
double legend_unit(unsigned picture_height);

/// Paints bar, ticks at round values and label into the picture's right margin. `open_ended`: the range is
/// what was seen so far, which the legend says. Nothing in pictures too small to hold it (below 160 x 120).
void draw_legend(Image& image, const std::string& label, double low, double high, bool open_ended);

} // namespace pliant::gl

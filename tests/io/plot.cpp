// Plots and letters: ticks against what a person would choose, curves where their numbers say, legends beside
// the data.
#include "engine/render/plot.h"
#include "engine/core/error.h"
#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "engine/render/font.h"
#include "engine/render/plot_axis.h"
#include "tests/io/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

using namespace pliant;
using pliant::test::ScratchFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

namespace {

std::vector<std::string> labels(const Axis& axis) {
  std::vector<std::string> all;
  for (const Tick& tick : axis.ticks())
    if (!tick.label.empty()) all.push_back(tick.label);
  return all;
}

std::size_t count(const Image& image, Colour colour, unsigned left, unsigned top, unsigned right,
                  unsigned bottom) {
  std::size_t hits = 0;
  for (unsigned y = top; y < bottom; ++y)
    for (unsigned x = left; x < right; ++x) {
      const std::uint8_t* p = image.at(x, y);
      hits += p[0] == colour[0] && p[1] == colour[1] && p[2] == colour[2];
    }
  return hits;
}

constexpr Colour red = {255, 0, 0}, black = {0, 0, 0}, white = {255, 255, 255};

} // namespace

TEST(PlotAxis, LinearTicksAreRoundNumbers) {
  EXPECT_THAT(labels(Axis(false, 0.03, 0.97, {}, 5, 0)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(labels(Axis(false, -1, 1, {}, 4, 0)), ElementsAre("-1.0", "-0.5", "0", "0.5", "1.0"));
  EXPECT_THAT(labels(Axis(false, 0, 3e-7, {}, 3, 0)), ElementsAre("0", "1e-7", "2e-7", "3e-7"));
  EXPECT_THAT(labels(Axis(false, 0, 1000000, {}, 2, 0)), ElementsAre("0", "5e5", "1e6"));
  EXPECT_THAT(labels(Axis(false, 100000.1, 100000.3, {}, 2, 0)),
              ElementsAre("100000.1", "100000.2", "100000.3"));
}

TEST(PlotAxis, LogarithmicTicksAreDecades) {
  EXPECT_THAT(labels(Axis(true, 0.02, 800, {}, 6, 0)), ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  EXPECT_THAT(labels(Axis(true, 3e-8, 0.5, {}, 6, 0)), testing::Contains("1e-8"));
  EXPECT_THAT(labels(Axis(true, 1.1, 4.5, {}, 6, 0)), ElementsAre("1", "2", "5"));
  const Axis axis(true, 1, 100, {}, 6, 0);
  EXPECT_DOUBLE_EQ(axis.place(1), 0);
  EXPECT_DOUBLE_EQ(axis.place(10), 0.5);
  EXPECT_DOUBLE_EQ(axis.place(100), 1);
  EXPECT_FALSE(axis.can_show(0));
  EXPECT_FALSE(axis.can_show(std::nan("")));
}

// Data of any size must give an axis that holds them, with a handful of labels and none twice.
TEST(PlotAxis, AnyRangeGetsAUsefulAxis) {
  for (const bool logarithmic : {false, true})
    for (int e = -30; e <= 30; e += 3)
      for (const double ratio : {1.0, 1.0 + 1e-12, 1.001, 1.7, 30.0, 1e6, 1e20}) {
        const double low = std::pow(10.0, e) * 1.37, high = low * ratio;
        const Axis axis(logarithmic, low, high, {}, 8, 0);
        EXPECT_GE(axis.place(low), -1e-6) << low << " " << high;
        EXPECT_LE(axis.place(high), 1 + 1e-6) << low << " " << high;
        EXPECT_LE(axis.ticks().size(), 130u) << low << " " << high;
        const auto all = labels(axis);
        EXPECT_GE(all.size(), 1u) << low << " " << high << " " << logarithmic;
        EXPECT_LE(all.size(), 16u) << low << " " << high << " " << logarithmic;
        EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size()) << low << " " << high;
      }
}

TEST(Font, EveryCharacterIsDrawnAndDiffersFromTheOthers) {
  std::set<std::vector<std::uint8_t>> seen;
  for (char c = 32; c < 127; ++c) {
    Image image(20, 30, white);
    draw_text(image, 4, 4, std::string(1, c), 14, black);
    if (c != ' ') {
      EXPECT_GT(count(image, black, 0, 0, 20, 30), 2u) << c;
    }
    EXPECT_TRUE(seen.insert(image.pixels).second) << c;
  }
}

TEST(Font, TextStaysInTheBoxThatWasMeasured) {
  const std::string text = "Mgjy_|@ 123";
  for (const double size : {7.0, 10.0, 21.0}) {
    const TextSize box = measure_text(text, size);
    for (const bool upwards : {false, true}) {
      Image image(400, 400, white);
      draw_text(image, 50, upwards ? 350 : 50, text, size, black, upwards);
      const double right = 50 + (upwards ? box.height : box.width), top = upwards ? 350 - box.width : 50;
      const double bottom = upwards ? 350 : 50 + box.height;
      std::size_t inside = 0;
      for (unsigned y = 0; y < 400; ++y)
        for (unsigned x = 0; x < 400; ++x) {
          if (image.at(x, y)[0] == 255) continue;
          const bool in = x + 1 >= 49 && x <= right + 1 && y + 1 >= top - 1 && y <= bottom + 1;
          EXPECT_TRUE(in) << x << " " << y;
          inside += in;
        }
      EXPECT_GT(inside, 100u);
    }
  }
  EXPECT_EQ(measure_text("", 10).width, 0);
  EXPECT_EQ(measure_text("\xc3\xa4", 10).width, measure_text("a", 10).width); // one code point, one character
}

TEST(Font, TextBeyondThePictureIsCut) {
  Image image(10, 10, white);
  draw_text(image, -30, -5, "far outside, and back", 12, black);
  draw_text(image, 5000, 5000, "far outside", 12, black);
  EXPECT_EQ(image.pixels.size(), 300u);
}

// With a given range the frame's corners are known: the curve of y = x goes from the lower left to the upper
// right.
TEST(Plot, CurvesLieWhereTheirNumbersSay) {
  Plot plot;
  plot.x_range = plot.y_range = {0, 10};
  Series series{"", {0, 10, 100}, {0, 10, 100}, {}};
  series.style.markers = false;
  series.style.colour = red;
  plot.series = {series};
  const Image image = draw_plot(plot);
  unsigned left = 999, right = 0, top = 999, bottom = 0;
  for (unsigned y = 0; y < image.height; ++y)
    for (unsigned x = 0; x < image.width; ++x)
      if (image.at(x, y)[0] > 200 && image.at(x, y)[1] < 60) {
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
        bottom = std::max(bottom, y);
      }
  ASSERT_GT(right, left + 600);
  ASSERT_GT(bottom, top + 400);
  const auto near = [&](double share) {
    const auto x = static_cast<unsigned>(left + share * (right - left)),
               y = static_cast<unsigned>(bottom - share * (bottom - top));
    return count(image, red, x - 3, y - 3, x + 4, y + 4);
  };
  for (const double share : {0.1, 0.25, 0.5, 0.9}) EXPECT_GT(near(share), 0u) << share;
  EXPECT_EQ(count(image, red, 0, 0, image.width, top), 0u); // what lies beyond the range is cut at the frame
}

TEST(Plot, PointsThatCannotBeShownBreakTheLine) {
  Plot plot;
  plot.log_y = true;
  plot.x_range = {0, 4};
  plot.y_range = {0.1, 10};
  Series series{"", {0, 1, 2, 3, 4}, {1, 1, -1, 1, 1}, {}};
  series.style.markers = false;
  series.style.colour = red;
  plot.series = {series};
  const Image image = draw_plot(plot);
  EXPECT_GT(count(image, red, 80, 0, 250, 640), 100u);
  EXPECT_EQ(count(image, red, 400, 0, 600, 640), 0u);
  EXPECT_GT(count(image, red, 750, 0, 930, 640), 100u);
}

// The box of the legend is the only thing that can hide a curve: with and without labels the same red must be
// seen.
TEST(Plot, TheLegendHidesNoData) {
  for (int kind = 0; kind < 3; ++kind) {
    Plot plot;
    plot.x_range = {0, 1};
    plot.y_range = {-1, 1};
    Series series{"a label of some length", {}, {}, {}};
    series.style.colour = red;
    series.style.markers = false;
    for (int i = 0; i <= 2000; ++i) {
      series.x.push_back(i / 2000.0);
      series.y.push_back(kind == 0   ? i / 1000.0 - 1
                         : kind == 1 ? 1 - i / 1000.0
                                     : std::sin(0.3 * i)); // the last fills all
    }
    plot.series = {series};
    const Image with = draw_plot(plot);
    plot.series[0].label.clear();
    const Image without = draw_plot(plot);
    if (kind < 2) {
      EXPECT_GE(count(with, red, 0, 0, 960, 640), count(without, red, 0, 0, 960, 640)) << kind;
      EXPECT_NE(with.pixels, without.pixels);
    } else {
      // No room inside: the frame is narrower and the legend stands to its right, where nothing else is red.
      const auto right = count(with, red, 800, 0, 960, 640);
      EXPECT_GT(right, 20u);
      EXPECT_LT(right, 200u);
    }
  }
}

TEST(Plot, SvgSaysTheSameAndIsWellFormed) {
  ScratchFolder folder;
  Plot plot;
  plot.title = "a < b & \"c\"";
  plot.x_label = "time (s)";
  plot.y_label = "Poisson's ratio \xce\xbd";
  plot.series = {{"one", {1, 2, 3}, {1, 4, 9}, {}}, {"two", {1, 2, 3}, {2, 3, 4}, {}}};
  plot.series[1].style.dashed = true;
  write_svg(plot, folder.path / "a.svg");
  const std::string text = read_text_file(folder.path / "a.svg");
  EXPECT_THAT(text, HasSubstr("a &lt; b &amp; \"c\""));
  EXPECT_THAT(text, HasSubstr("time (s)"));
  EXPECT_THAT(text, HasSubstr("\xce\xbd"));
  EXPECT_THAT(text, HasSubstr("#0072b2"));
  EXPECT_THAT(text, HasSubstr("#d55e00"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  const auto answer =
      test::run_program("/usr/bin/python3 -c \"import sys, xml.dom.minidom as m; m.parse(sys.argv[1])\" '" +
                        (folder.path / "a.svg").string() + "'");
  EXPECT_EQ(answer.status, 0) << answer.text;
  write_png(plot, folder.path / "a.png");
  const Image image = read_png(folder.path / "a.png");
  EXPECT_EQ(image.width, 960u);
  EXPECT_GT(count(image, {0, 114, 178}, 0, 0, 960, 640), 500u);
}

TEST(Plot, NothingToShowIsNoFailure) {
  Plot plot;
  plot.title = "empty";
  EXPECT_EQ(draw_plot(plot).width, 960u);
  plot.log_x = plot.log_y = true;
  plot.series = {{"none", {}, {}, {}},
                 {"not positive", {0, -1}, {1, 1}, {}},
                 {"not finite", {NAN, 1}, {1, INFINITY}, {}}};
  EXPECT_EQ(draw_plot(plot).height, 640u);
  plot.series = {{"unequal", {1, 2}, {1}, {}}};
  EXPECT_THROW(draw_plot(plot), Error);
}

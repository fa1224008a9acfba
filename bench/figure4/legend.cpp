// SPDX-License-Identifier: Apache-2.0
#include "bench/figure4/legend.h"

#include "apps/viewer/canvas.h"

namespace pbdsurg::bench {
namespace {

constexpr double kFont = 2.2;
constexpr double kMargin = 46, kTop = 66, kBarWidth = 44;  // pixels

}  // namespace

cholecystectomy::Image draw_legend(const Legend& legend, int width, int height) {
  using cholecystectomy::kInk;
  using cholecystectomy::Text;
  cholecystectomy::Canvas canvas(width, height);
  const double bottom = height - 24.0, left = kMargin, right = kMargin + kBarWidth;
  canvas.text(Text(legend.title), {left, 24}, kFont, kInk);
  canvas.fill({left - 1, kTop - 1}, {right + 1, bottom + 1}, kInk);
  const auto value_at = [&](double y) {
    return legend.low + (legend.high - legend.low) * (bottom - y) / (bottom - kTop);
  };
  for (double y = kTop; y < bottom; y += 1) {
    const Color color = legend.color_of(value_at(y + 0.5));
    canvas.fill({left, y}, {right, y + 1},
                {to_byte(color.red), to_byte(color.green), to_byte(color.blue)});
  }
  for (const Legend::Tick& tick : legend.ticks) {
    const double y =
        bottom - (bottom - kTop) * (tick.value - legend.low) / (legend.high - legend.low);
    canvas.fill({right, y - 1}, {right + 8, y + 1}, kInk);
    canvas.text(Text(tick.label), {right + 14, y - kFont * cholecystectomy::kFontHeight / 2}, kFont,
                kInk);
  }
  return canvas.image();
}

}  // namespace pbdsurg::bench

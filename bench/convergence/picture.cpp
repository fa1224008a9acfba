// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/picture.h"

#include <cmath>

#include "apps/viewer/montage.h"
#include "apps/viewer/plot.h"
#include "apps/viewer/png.h"

namespace pbdsurg::bench {
namespace {

// What explodes, or takes many times longer than sweeps do, would flatten all others.
constexpr double kHighest = 100;
constexpr double kLongest = 2;

template <class Curve>
cholecystectomy::PlotSeries series_of(const Curve& curve, double Curve::Point::*value,
                                      double most_ms) {
  cholecystectomy::PlotSeries series{curve.method->name, {}, {}};
  for (const auto& point : curve.points) {
    if (point.ms <= most_ms && point.*value < kHighest) {
      series.x.push_back(point.ms);
      series.y.push_back(std::log10(point.*value));
    }
  }
  return series;
}

template <class Curve>
cholecystectomy::CaptionedImage plot_curves(const std::string& title,
                                            const std::vector<Curve>& curves,
                                            double Curve::Point::*value) {
  cholecystectomy::Plot plot;
  plot.x_label = "compute [ms]";
  plot.y_label = "log10";
  for (const Curve& curve : curves) {
    plot.series.push_back(series_of(curve, value, kLongest * curves.front().points.back().ms));
  }
  return {title, cholecystectomy::plot_lines(plot)};
}

}  // namespace

void draw_curves(const Comparison& comparison, const std::filesystem::path& path) {
  std::vector<RestCurve> rests;
  for (const RestCurve& curve : comparison.rests) {
    if (curve.is_best) {
      rests.push_back(curve);
    }
  }
  const std::vector<cholecystectomy::CaptionedImage> plots{
      plot_curves("residual of one step", comparison.steps, &StepCurve::Point::residual),
      plot_curves("residual on the way to rest", rests, &RestCurve::Point::residual),
      plot_curves("tip error on the way to rest", rests, &RestCurve::Point::tip_error)};
  cholecystectomy::write_png(path, cholecystectomy::make_montage(plots, 1));
}

}  // namespace pbdsurg::bench

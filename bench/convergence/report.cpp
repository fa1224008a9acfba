// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/report.h"

#include <algorithm>
#include <cmath>

namespace pbdsurg::bench {
namespace {

// What diverges is null, as everything that is not there.
Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json ratio(const std::optional<double>& value, const std::optional<double>& base) {
  return value && base ? rounded(*value / *base, 1e3) : Json();
}

double dt_in_ms(const Comparison& comparison) {
  return std::round(1e6 * comparison.dt) / 1e3;
}

const StepCurve& step_curve_of(const Comparison& comparison, const Method* method) {
  return *std::find_if(comparison.steps.begin(), comparison.steps.end(),
                       [&](const StepCurve& curve) { return curve.method == method; });
}

const StepCurve::Point& reference_of(const Comparison& comparison) {
  const auto& points = comparison.steps.at(0).points;
  return *std::find_if(points.begin(), points.end(), [](const StepCurve::Point& point) {
    return point.sweeps == kReferenceSweeps;
  });
}

Json to_json(const Comparison& comparison, const RestCurve& curve) {
  const StepCurve::Point& reference = reference_of(comparison);
  const auto ms_to_residual = ms_until(step_curve_of(comparison, curve.method),
                                       &StepCurve::Point::residual, reference.residual);
  const auto ms_to_tip_error = [](const RestCurve& any) {
    return ms_until(any, &RestCurve::Point::tip_error, kTipTolerance);
  };
  const auto& last = curve.points.back();
  return {{"dt_ms", dt_in_ms(comparison)},
          {"method", curve.method->name},
          {"substeps", curve.setting.substeps},
          {"iterations", curve.setting.iterations},
          {"threads", curve.method->threads},
          {"best", curve.is_best},
          {"ms_to_residual", rounded(ms_to_residual, 1e3)},
          {"ms_to_residual_of_sweeps", ratio(ms_to_residual, reference.ms)},
          {"ms_per_step", rounded(last.ms / static_cast<double>(curve.points.size()), 1e3)},
          {"ms_to_tip_error", rounded(ms_to_tip_error(curve), 1e3)},
          {"ms_to_tip_error_of_sweeps",
           ratio(ms_to_tip_error(curve), ms_to_tip_error(comparison.rests.at(0)))},
          {"last_residual", finite(last.residual)},
          {"last_tip_error", finite(last.tip_error)}};
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{{"substeps", "substeps", 0},
                                       {"iterations", "sweeps of each", 0},
                                       {"threads", "threads", 0},
                                       {"ms_to_residual", "ms to the residual of 30 sweeps", 2},
                                       {"ms_to_residual_of_sweeps", "of theirs", 3},
                                       {"ms_per_step", "one step, ms", 2},
                                       {"ms_to_tip_error", "ms to 1 % of tip error", 1},
                                       {"ms_to_tip_error_of_sweeps", "of that of 30 sweeps", 3},
                                       {"last_tip_error", "tip error in the end", 5},
                                       {"last_residual", "residual in the end", 4}};
  return all;
}

}  // namespace

Json to_json(const std::vector<Comparison>& comparisons) {
  Json rows = Json::array();
  for (const Comparison& comparison : comparisons) {
    for (const RestCurve& curve : comparison.rests) {
      rows.push_back(to_json(comparison, curve));
    }
  }
  return rows;
}

Json points_of(const std::vector<Comparison>& comparisons) {
  Json rows = Json::array();
  const auto add = [&](const Comparison& comparison, const char* curve, const Method& method,
                       const Setting& setting, const Json& is_best) -> Json& {
    rows.push_back({{"dt_ms", dt_in_ms(comparison)},
                    {"curve", curve},
                    {"method", method.name},
                    {"substeps", setting.substeps},
                    {"iterations", setting.iterations},
                    {"best", is_best},
                    {"time_s", Json()},
                    {"ms", Json()},
                    {"residual", Json()},
                    {"tip_error", Json()}});
    return rows.back();
  };
  for (const Comparison& comparison : comparisons) {
    for (const StepCurve& curve : comparison.steps) {
      for (const StepCurve::Point& point : curve.points) {
        Json& row = add(comparison, "step", *curve.method, with_sweeps(*curve.method, point.sweeps),
                        Json());
        row["ms"] = rounded(point.ms, 1e4);
        row["residual"] = finite(point.residual);
      }
    }
    for (const RestCurve& curve : comparison.rests) {
      for (const RestCurve::Point& point : curve.points) {
        Json& row = add(comparison, "rest", *curve.method, curve.setting, curve.is_best);
        row["time_s"] = rounded(point.time_s, 1e6);
        row["ms"] = rounded(point.ms, 1e4);
        row["residual"] = finite(point.residual);
        row["tip_error"] = finite(point.tip_error);
      }
    }
  }
  return rows;
}

std::string to_markdown(const Json& rows, const std::vector<std::string>& notes) {
  std::string text = "# Convergence\n\n";
  for (const std::string& note : notes) {
    text += "- " + note + "\n";
  }
  Json dt;
  for (const Json& row : rows) {
    if (row["dt_ms"] != dt) {
      dt = row["dt_ms"];
      text += "\n## Steps of " + text_of(dt) + " ms\n\n" + markdown_header("method", columns());
    }
    const std::string name = row["method"];
    text += markdown_line(row["best"] == true ? "**" + name + "**" : name, row, columns());
  }
  return text;
}

}  // namespace pbdsurg::bench

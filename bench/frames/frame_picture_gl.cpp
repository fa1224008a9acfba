// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/heat/tissue_color.h"

#include "apps/cholecystectomy/skin_changes.h"
#include "apps/viewer/instruments.h"
#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#include "bench/frames/frame_picture.h"
#include "bench/frames/worker.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::Image;
using cholecystectomy::OffscreenRenderer;
using cholecystectomy::RenderQuality;
using cholecystectomy::SceneView;
using cholecystectomy::SurfaceChange;

bool names_software(const std::string& renderer) {
  return std::ranges::any_of(
      std::array{"llvmpipe", "softpipe", "swrast", "SwiftShader"},
      [&](const char* name) { return renderer.find(name) != std::string::npos; });
}

// Through the laparoscope, on both organs and both instruments.
SceneView view_of(const FrameWorld& world) {
  SceneView view;
  view.camera.up = {0, 0, 1};
  view.camera.target = {0.012F, 0, 0.008F};
  view.camera.eye = {-0.055F, -0.085F, -0.045F};
  view.tools = {cholecystectomy::draw_hook(world.hook_pose()),
                cholecystectomy::draw_grasper(world.grasper_pose(), true)};
  return view;
}

cholecystectomy::Surface backdrop() {
  const MeshData mesh = abdominal_wall();
  cholecystectomy::Surface wall;
  wall.name = "abdominal_wall";
  wall.look = tissues::abdominal_wall().look;
  wall.casts_shadow = false;
  wall.triangles = mesh.triangles;
  for (const Eigen::Vector3d& x : mesh.points) {
    wall.positions.push_back(x.cast<float>());
  }
  return wall;
}

class GlFramePicture final : public FramePicture {
 public:
  explicit GlFramePicture(const FrameWorld& world) : world_(world), view_(view_of(world)) {
    worker_.start([&] {
      try {
        make_renderer();
      } catch (...) {
        renderer_.reset();  // here, as below
        throw;
      }
    });
    worker_.wait();
  }

  ~GlFramePicture() override {
    worker_.start([&] { renderer_.reset(); });  // OpenGL objects end on the thread of their context
  }

  void start() override {
    worker_.wait();
    for (std::size_t b = 0; b < kept_.size(); ++b) {
      collect(*world_.surfaces()[b], kept_[b]);
    }
    view_ = view_of(world_);
    worker_.start([&] {
      upload_ms_ = time_of([&] {
        for (std::size_t b = 0; b < kept_.size(); ++b) {
          renderer_->update(b, kept_[b].change);
        }
      });
      renderer_->draw(view_);
    });
  }

  double finish() override {
    worker_.wait();
    return upload_ms_;
  }

  void write(const std::filesystem::path& path) override {
    Image image;
    worker_.start([&] { image = renderer_->render(view_); });
    worker_.wait();
    const auto [least, most] = std::ranges::minmax_element(image.rgb);
    if (*most - *least < 64) {
      throw Error("the picture of a frame on " + renderer() + " shows nothing");
    }
    cholecystectomy::write_png(path, image);
  }

  [[nodiscard]] const std::string& renderer() const override { return renderer_->device_name(); }
  [[nodiscard]] bool is_software() const override { return is_software_; }

 private:
  // Of a body: what the renderer has seen of it.
  struct Kept {
    std::uint64_t triangles = 0, marks = 0;
    SurfaceChange change;
  };

  void make_renderer() {
    renderer_.emplace(options(RenderQuality::quick()));
    is_software_ = names_software(renderer_->device_name());
    if (!is_software_) {
      renderer_.emplace(options(RenderQuality::full()));
    }
    const std::array looks{tissues::gallbladder_wall().look, tissues::liver().look};
    std::vector<cholecystectomy::Surface> surfaces;
    for (std::size_t b = 0; b < looks.size(); ++b) {
      const Surface& skin = *world_.surfaces()[b];
      cholecystectomy::Surface& surface = surfaces.emplace_back();
      surface.name = b == 0 ? "gallbladder" : "liver";
      surface.look = surface.inner_look = looks[b];
      surface.positions.assign(skin.positions().begin(), skin.positions().end());
      surface.rest_positions.assign(skin.rest_positions().begin(), skin.rest_positions().end());
      surface.triangles.assign(skin.triangles().begin(), skin.triangles().end());
      surface.burn.assign(surface.positions.size(), Eigen::Vector4f::Zero());
      kept_[b].triangles = skin.version();
      kept_[b].change.positions = surface.positions;
    }
    surfaces.push_back(backdrop());
    renderer_->set_surfaces(surfaces);
    renderer_->draw(view_);
  }

  void collect(const Surface& skin, Kept& kept) {
    SurfaceChange& change = kept.change;
    cholecystectomy::collect_skin_changes(skin, change.positions.size(), kept.triangles, ranges_,
                                          change);
    kept.triangles = skin.version();
    skin.collect_mark_changes(kept.marks, ranges_);
    kept.marks = skin.marks_version();
    change.burns.resize(ranges_.size());
    for (std::size_t r = 0; r < ranges_.size(); ++r) {
      change.burns[r].first = ranges_[r].first;
      change.burns[r].values.clear();
      for (Index v = ranges_[r].first; v < ranges_[r].end; ++v) {
        const Color color =
            burn_layer(ColorRule::state, skin.peak_temperatures()[v], burn_marks(skin.marks()[v]));
        change.burns[r].values.emplace_back(color.red, color.green, color.blue, color.alpha);
      }
    }
  }

  static cholecystectomy::OffscreenOptions options(const RenderQuality& quality) {
    return {.width = kFrameWidth, .height = kFrameHeight, .quality = quality};
  }

  const FrameWorld& world_;
  SceneView view_;
  std::array<Kept, 2> kept_;
  std::vector<SlotRange> ranges_;  // scratch
  // of the worker
  std::optional<OffscreenRenderer> renderer_;
  bool is_software_ = false;
  double upload_ms_ = 0;
  Worker worker_;
};

}  // namespace

std::unique_ptr<FramePicture> make_frame_picture(const FrameWorld& world) {
  return std::make_unique<GlFramePicture>(world);
}

}  // namespace pbdsurg::bench

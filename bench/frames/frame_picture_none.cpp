// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/frame_picture.h"

namespace pbdsurg::bench {

std::unique_ptr<FramePicture> make_frame_picture(const FrameWorld&) {
  throw BackendUnavailable(
      "built without pictures; EGL and libepoxy would switch them on, as configuring says");
}

}  // namespace pbdsurg::bench

// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/servo.h"

#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a tick that waits for the heap's lock, as any allocation may.
TEST_CASE("servo: ticks and packets allocate nothing", "[unit]") {
  ServoState state;
  Mailbox<ContactPacket> mailbox;
  ServoInput input;
  float most = 0;
  const long before = testing::allocation_count;
  for (int i = 0; i < 4000; ++i) {
    if (i % 10 == 0) {
      ContactPacket& packet = mailbox.draft();
      packet = {};
      packet.sequence = static_cast<std::uint64_t>(i) + 1;
      packet.time = i * 1e-3;
      packet.plane_count = ContactPacket::kLargestPlaneCount;
      packet.force = {0.1F, i > 2000 ? 1.0F : 0.0F, 0};
      packet.grasp.state = i > 3000 ? GraspState::held : GraspState::open;
      fit_to_force(packet, 100);
      mailbox.publish();
    }
    mailbox.take();
    input.time = i * 1e-3;
    most = std::max(most, servo_tick(state, mailbox.value(), input).commanded.norm());
  }
  CHECK(testing::allocation_count == before);
  CHECK(most > 0.5F);
}

}  // namespace pbdsurg

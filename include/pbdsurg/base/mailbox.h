// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The newest value of one thread for another, of which neither ever waits.

#include <algorithm>
#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace pbdsurg {

/// Holds the newest value that one writer published for one reader: poses and forces between a
/// servo thread at 1000 Hz and a simulation, positions for a renderer.
///
///     mailbox.draft().assign(positions.begin(), positions.end());  // writer
///     mailbox.publish();
///
///     if (mailbox.take() > 0) {  // reader
///       upload(mailbox.value());
///     }
///
/// Values that the reader did not take in time are lost: a mailbox is no queue. A value is taken
/// whole or not at all, and stays as it is until the reader takes the next one, whatever the writer
/// does meanwhile. Everything that the writer did before publish() is seen by the reader after the
/// take() that gets that value.
///
/// The three slots (triple buffering) are made with the mailbox and are filled in turn, in place:
/// containers keep their capacity, so that a writer which publishes values of one size allocates
/// nothing after its third.
///
/// One thread at a time may call what is the writer's, and one what is the reader's; a single
/// thread may be both. Two writers or two readers are a data race, which nothing here detects: give
/// each reader a mailbox of its own. Roles may pass to another thread where something else orders
/// the two, as the end of a thread does. Both threads end before the mailbox does.
///
/// sequence() tells values apart, not how old they are. Whoever must know the age puts the time at
/// which it was made into the value, by a clock that both sides share; or counts its own rounds
/// since take() last gave one, as a servo does to notice a simulation that has stopped.
///
/// Cost: of publish() one atomic exchange, of take() one load, and one exchange if there is a newer
/// value; a single instruction each on x86-64 and ARM from version 8.1 on, so that both are
/// wait-free there, and lock-free elsewhere. Each side writes cache lines of its own but for the
/// line that is exchanged.
///
/// @tparam T  any object that can be made without arguments, or copied; it need not be movable
template <class T>
class Mailbox {
  static_assert(std::is_object_v<T> && !std::is_const_v<T>, "the writer fills values in place");

 public:
  /// Slots are T{}. Throws what the constructor of T throws.
  Mailbox() requires std::default_initializable<T> {}

  /// Slots are copies, so that the reader has a value before the first one is published. Throws
  /// what the copy constructor of T throws.
  explicit Mailbox(const T& value) requires std::copy_constructible<T>
      : slots_{Slot{value}, Slot{value}, Slot{value}} {}

  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// The writer's: what publish() will publish. It holds some older value, so write all of it. If
  /// that throws, nothing was published, and the draft is to be written anew.
  /// @return  valid until publish(), which makes another slot the draft
  [[nodiscard]] T& draft() noexcept { return slots_[draft_].value; }

  /// The writer's: makes the draft the newest value, in place of one that was not taken.
  /// @return  its sequence number: 1 for the first, then ascending by one
  std::uint64_t publish() noexcept {
    slots_[draft_].sequence = ++published_;
    // Release: the reader sees what was written into the slot. Acquire: the reader is done with the
    // slot that comes back before the writer fills it.
    draft_ = exchanged_.exchange(draft_ | kNewer, std::memory_order_acq_rel) & kSlot;
    return published_;
  }

  /// The reader's: makes the newest value value(), if it was not taken before.
  /// @return  how many values were published since the one that was taken last: 0 if none, so that
  ///          value() is as before; n if this is the newest of n, of which n - 1 are lost
  std::uint64_t take() noexcept {
    // Relaxed: only the exchange gives access to a slot, and only the reader clears the mark.
    if ((exchanged_.load(std::memory_order_relaxed) & kNewer) == 0) {
      return 0;
    }
    const std::uint64_t before = sequence();
    // Acquire: as above, what was written into the slot. Release: the reader is done with the old.
    taken_ = exchanged_.exchange(taken_, std::memory_order_acq_rel) & kSlot;
    return sequence() - before;
  }

  /// The reader's: the value that was taken last; before any, as the mailbox was made.
  /// @return  valid and unchanged until a take() that returns more than 0
  [[nodiscard]] const T& value() const noexcept { return slots_[taken_].value; }

  /// The reader's: what publish() returned for value(); 0 before any was taken.
  [[nodiscard]] std::uint64_t sequence() const noexcept { return slots_[taken_].sequence; }

 private:
  using Word = std::uint32_t;
  static_assert(std::atomic<Word>::is_always_lock_free);
  static constexpr Word kSlot = 3;   // of a word: which slot
  static constexpr Word kNewer = 4;  // of a word: it was published and not taken

  // Two lines of cache, since processors fetch neighbours in pairs.
  static constexpr std::size_t kApart = 128;
  struct alignas(std::max(kApart, alignof(T))) Slot {
    T value{};
    std::uint64_t sequence = 0;
  };

  // Of the three slots one is the writer's, one the reader's, one lies ready to be exchanged.
  Slot slots_[3];
  alignas(kApart) Word draft_ = 0;  // the writer's
  std::uint64_t published_ = 0;     // the writer's
  alignas(kApart) std::atomic<Word> exchanged_{1};
  alignas(kApart) Word taken_ = 2;  // the reader's
};

}  // namespace pbdsurg

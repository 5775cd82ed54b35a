// Batches of a traverser whose rays SIMD code traces on a CPU: its functions, and what the executor makes of them (exec/cpu.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Closest-hit and any-hit queries. May throw std::bad_alloc where rays go by turns.
template <class View>
struct SimdFunctions {
  void (*closest)(const View&, const Ray*, std::size_t count, Hit*);
  void (*occluded)(const View&, const Ray*, std::size_t count, std::uint8_t*);

  void trace(const View& view, const Ray* rays, std::size_t count, Hit* hits) const { closest(view, rays, count, hits); }
  void trace(const View& view, const Ray* rays, std::size_t count, std::uint8_t* answers) const {
    occluded(view, rays, count, answers);
  }
};

// Batches of a method on a CPU: see exec/cpu.h. Simd::functions() are SimdFunctions of the view; where there are none,
// rays are traced one by one.
template <class View, class Simd, Query kQuery, class TraceSingly>
class SimdBatch {
 public:
  struct Options {
    std::size_t block_size = 1024;
  };
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;
  static constexpr bool kIsTuned = requires { Simd::functions(); };
  static constexpr std::size_t kFewestRays = 0;

  SimdBatch(const View& view, const Options&, const TraceSingly& trace_singly) : view_(view), trace_singly_(trace_singly) {}

  static void trace_one(const View& view, const Ray& ray, Answer& answer) requires(kIsTuned) {
    // The machine's code, looked up once and not for each ray.
    static const auto functions = Simd::functions();
    functions.trace(view, &ray, 1, &answer);
  }

  void trace(std::span<const Ray> rays, std::span<Answer> answers) const {
    if constexpr (kIsTuned)
      Simd::functions().trace(view_, rays.data(), rays.size(), answers.data());
    else
      for (std::size_t i = 0; i < rays.size(); ++i) store_answer(trace_singly_(rays[i]), answers[i]);
  }

 private:
  const View& view_;
  const TraceSingly& trace_singly_;
};

}  // namespace accel

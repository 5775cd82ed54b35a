// One step of one ray in the multipass executor: a kernel's work, and which kernel the ray waits for next. The executors for
// CPUs and CUDA share it.
//
// Foley and Sugerman 2005 [FS05], section 3.3, over the state machine of trace/traverser.h:
//
//   Initialize  begin()
//   Down        descend(), one inner node
//   Leaf        a ray that has reached a leaf, by whichever step, gets ready for its primitives, of which there may be none
//   Intersect   intersect(), one primitive
//   Continue    a ray that has done with a leaf ends, or makes its first backtrack() step
//   Up          backtrack(), further steps
//
// So every leaf that is visited, an empty one too, takes one Leaf and one Continue: the paper's transitions. Leaf has no work
// of its own, since our descend() enters the leaf. Where a traverser goes on downwards by itself, from an empty leaf or after a
// leaf's last primitive, as a grid's does, there is nothing to decide, and no transition: the paper's grid has none either.
// Deviation: Up also serves traversers that backtrack without having seen a leaf, as a BVH's does when a ray misses both
// children; and where a traverser with a stack pops, that is its backtrack() step.
#pragma once

#include "libaccel/exec/multipass_profile.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// The least that a step's observer has to remember: whether a leaf was reached since this was last set to false.
struct LeafObserver : NullObserver {
  bool leaf_reached = false;

  ACCEL_HD void leaf_visit(std::uint32_t) { leaf_reached = true; }
};

// Whether the kernel calls the traverser for a ray in this phase, rather than pass the ray on.
ACCEL_HD bool calls_traverser(MultipassKernel kernel, Phase phase) {
  if (kernel == MultipassKernel::continue_search) return phase == Phase::backtrack;
  return kernel != MultipassKernel::leaf;
}

// Where a ray goes from `kernel` that is in this phase now.
ACCEL_HD MultipassKernel kernel_after(MultipassKernel kernel, Phase phase, bool leaf_reached) {
  if (phase == Phase::descend) return MultipassKernel::down;
  if (leaf_reached) return MultipassKernel::leaf;
  if (phase == Phase::intersect) return MultipassKernel::intersect;
  const bool leaves_leaf = kernel == MultipassKernel::leaf || kernel == MultipassKernel::intersect;
  if (leaves_leaf) return MultipassKernel::continue_search;
  return phase == Phase::backtrack ? MultipassKernel::up : MultipassKernel::finished;
}

// What a ray carries from kernel to kernel; its stack, if any, is where the state points to.
template <class Traverser>
struct MultipassRay {
  const Ray& ray;
  typename Traverser::State& state;
  Hit& hit;
  Phase& phase;
};

// One step. `phase` is read by Leaf and Continue only.
template <MultipassKernel kKernel, class Traverser, class Observer>
ACCEL_HD MultipassKernel multipass_step(const typename Traverser::View& view, const MultipassRay<Traverser>& r,
                                        Observer& observer) {
  observer.leaf_reached = false;
  if constexpr (kKernel == MultipassKernel::initialize)
    r.phase = Traverser::begin(view, r.ray, r.state, r.hit, observer);
  else if constexpr (kKernel == MultipassKernel::down)
    r.phase = Traverser::descend(view, r.ray, r.state, r.hit, observer);
  else if constexpr (kKernel == MultipassKernel::intersect)
    r.phase = Traverser::intersect(view, r.ray, r.state, r.hit, observer);
  else if constexpr (kKernel == MultipassKernel::up)
    r.phase = Traverser::backtrack(view, r.ray, r.state, r.hit, observer);
  else if (calls_traverser(kKernel, r.phase))
    r.phase = Traverser::backtrack(view, r.ray, r.state, r.hit, observer);
  const MultipassKernel next = kernel_after(kKernel, r.phase, observer.leaf_reached);
  if (next == MultipassKernel::finished) finish_hit(r.hit);
  return next;
}

}  // namespace accel

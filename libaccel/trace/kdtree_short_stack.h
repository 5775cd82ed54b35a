// Traversal of a kd-tree with a stack of few entries, restart and push-down: Horn, Sugerman, Houston and Hanrahan 2007,
// "Interactive k-D Tree GPU Raytracing".
//
// Short stack: a full stack drops its oldest entry. When the stack is empty although the ray has not ended, the traversal
// restarts as kd-restart does (kdtree_restart.h). Push-down: it restarts not from the root but from the lowest node below which
// the whole rest of the ray lies; as long as a descent from there meets no node with two children to visit, that node moves
// down with it.
//
// Needs no arrays beyond the nodes. Deviation: entries have no t_min (kdtree_stack.h).
#pragma once

#include "libaccel/trace/kdtree_common.h"

namespace accel {

template <class Test, Query kQuery>
struct KdTreeShortStack : KdTraversal<Test, kQuery> {
  static constexpr const char* kName = "short-stack";
  using View = KdTreeView;

  // Entries; a power of two.
  static constexpr std::uint32_t kSize = 4;

  struct Postponed {
    std::uint32_t node;
    float t_max;
  };
  // A ring.
  struct Stack {
    Postponed entries[kSize];
  };
  struct State : KdState<Test> {
    float t_end;
    std::uint32_t restart_at;
    std::uint32_t top;        // of the ring: where the next entry goes, modulo kSize
    std::uint32_t postponed;  // entries in the ring
    bool push_down;           // whether the descent has come from restart_at past single children only
    Stack* stack;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_kdtree(view, ray, state, hit)) return Phase::done;
    state.t_end = state.t_max;
    state.restart_at = kKdRoot, state.push_down = true;
    state.top = state.postponed = 0;
    return enter(view, kKdRoot, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    observer.node_step();
    const KdCrossing plane = crossing(view, state);
    if (!(plane.t > state.t_min)) return enter_only(view, plane.second(), state, observer);
    if (!(plane.t < state.t_max)) return enter_only(view, plane.first(), state, observer);
    push(state, {plane.second(), state.t_max}, observer);
    state.push_down = false;
    state.t_max = plane.t;
    return enter_first(plane, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (is_final(hit, state) || state.t_max >= state.t_end) return Phase::done;
    observer.backtrack();
    ACCEL_ASSERT(state.t_min < state.t_max);
    state.t_min = state.t_max;
    if (state.postponed == 0) {
      state.t_max = state.t_end;
      state.push_down = true;
      return enter(view, state.restart_at, state, observer);
    }
    const Postponed& entry = state.stack->entries[--state.top % kSize];
    observer.load(Memory::stack, &entry, sizeof entry);
    --state.postponed;
    state.t_max = entry.t_max;
    return enter(view, entry.node, state, observer);
  }

 private:
  // The child is the only one to visit.
  template <class Observer>
  ACCEL_HD static Phase enter_only(const View& view, std::uint32_t child, State& state, Observer& observer) {
    if (state.push_down) state.restart_at = child;
    return enter(view, child, state, observer);
  }

  template <class Observer>
  ACCEL_HD static void push(State& state, Postponed postponed, Observer& observer) {
    Postponed& entry = state.stack->entries[state.top++ % kSize];
    observer.store(Memory::stack, &entry, sizeof entry);
    entry = postponed;
    if (state.postponed < kSize) ++state.postponed;
  }
};

}  // namespace accel

// Traversal of two levels (structure/two_level.h, structure/two_level_bvh8.h) by any traverser of one: Binder and Keller 2016,
// section 2.4, "Pausing and Resuming": the state of the ray is stored, a new one is made for the instance, and on return the
// old one is resumed.
//
// A state is paused by copying it, and the base traverser is the same code on both levels, on another tree and with another
// ray. A leaf of the tree over instances is walked here. For that the base traverser offers two functions more:
//
//     ACCEL_HD static std::uint32_t& leaf(State&);  // the quad of the leaf that it is in, or the number of the instance
//     ACCEL_HD static Phase end_leaf(const View&, State&, const Hit&);  // what it does at the leaf's end
//
// Each specialisation of the base traverser makes one of these.
//
// Hits. Inside of an instance the search starts from no hit, in the interval that is left: it names the triangle with the
// lowest number in the mesh, ties with the hit so far included. accept_hit() then chooses between the two by their prim_ids in
// the scene, so that ties go to the lowest there too, whatever the order of the instances.
//
// Rays. t is the same on both levels (core/affine.h). A ray that is not traceable in an instance's space, because the map takes
// its origin or direction out of the library's range, passes it by.
//
// Why no hit is lost between the levels: see build/instances.h.
#pragma once

#include "libaccel/structure/two_level.h"
#include "libaccel/trace/traverser.h"

namespace accel {

template <class Base, Query kQuery, class LevelsView = TwoLevelView>
struct TwoLevel;

namespace detail {

// What the base traverser reads, where it says so.
template <class Base>
struct TwoLevelNeeds {};
template <class Base>
requires requires { Base::kNeeds; }
struct TwoLevelNeeds<Base> {
  static constexpr const auto& kNeeds = Base::kNeeds;
};

template <class Base>
struct TwoLevelTraits : TwoLevelNeeds<Base> {};
template <class Base>
requires requires { Base::kForDevices; }
struct TwoLevelTraits<Base> : TwoLevelNeeds<Base> {
  static constexpr bool kForDevices = Base::kForDevices;
};

template <class Base, Query kQuery, class LevelsView>
struct TwoLevelSpecialisations {
  using type = TypeList<>;
};
template <SpecialisedTraverser Base, Query kQuery, class LevelsView>
struct TwoLevelSpecialisations<Base, kQuery, LevelsView> {
  template <class... Ts>
  using Each = TypeList<TwoLevel<Ts, kQuery, LevelsView>...>;
  using type = typename Base::Specialisations::template Apply<Each>;
};

// A stack for each level, where the base traverser has one; nothing, not even a type, where it has none.
template <class Base>
struct TwoLevelStack {
  struct Pointer {};
};
template <StackTraverser Base>
struct TwoLevelStack<Base> {
  struct Stack {
    StackOf<Base> levels[2];
  };
  struct Pointer {
    Stack* stack;
  };
};

}  // namespace detail

// kQuery is the base traverser's, and LevelsView that of two levels of its structure.
template <class Base, Query kQuery, class LevelsView>
struct TwoLevel : detail::TwoLevelStack<Base>, detail::TwoLevelTraits<Base> {
  static constexpr const char* kName = Base::kName;
  using View = LevelsView;
  using Tree = typename View::Tree;
  using Specialisations = typename detail::TwoLevelSpecialisations<Base, kQuery, View>::type;
  static constexpr std::uint32_t kMaxDepth = Base::kMaxDepth;

  struct State : detail::TwoLevelStack<Base>::Pointer {
    typename Base::State active, paused;
    Tree tree;                 // of the active state
    Ray ray;                   // in its space
    Hit outside;               // the best hit when the instance was entered
    std::uint32_t first_prim;  // of the instance
    bool is_inside;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    begin_hit(ray, hit);
    s.is_inside = false;
    s.ray = ray;
    s.tree = view.top();
    tell_tree(view, 0, observer);
    return Base::begin(s.tree, s.ray, active(s), hit, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View&, const Ray&, State& s, Hit& hit, Observer& observer) {
    return Base::descend(s.tree, s.ray, active(s), hit, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    if (!s.is_inside) return enter_instance(view, ray, s, hit, observer);
    return or_leave(Base::intersect(s.tree, s.ray, active(s), hit, observer), view, ray, s, hit, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return or_leave(Base::backtrack(s.tree, s.ray, active(s), hit, observer), view, ray, s, hit, observer);
  }

 private:
  // The state on the level that the ray is on. Its stack is found anew each time: whoever pauses a ray may have moved it.
  ACCEL_HD static typename Base::State& active(State& s) {
    if constexpr (StackTraverser<Base>) s.active.stack = &s.stack->levels[s.is_inside ? 1 : 0];
    return s.active;
  }

  // Pauses the traversal of the tree over instances in front of what comes after the leaf's next instance, and enters that.
  template <class Observer>
  ACCEL_HD static Phase enter_instance(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    const auto& instance = view.instances[take_instance(s, observer)];
    observer.load(Memory::node, &instance, sizeof instance);
    s.paused = s.active, s.outside = hit;
    s.is_inside = true, s.first_prim = instance.first_prim;
    s.ray = instance.to_object.ray(ray);
    s.tree = view.tree_of(instance);
    tell_tree(view, instance.tree, observer);
    Hit whole_interval;  // not the one that is left
    const Phase phase = Base::begin(s.tree, s.ray, active(s), whole_interval, observer);
    hit.prim_id = kNoHit;
    // Tests that keep what they find (trace/multi_hit.h) go on keeping it.
    if constexpr (requires { s.active.test.enter_instance(s.paused.test, 0u); })
      s.active.test.enter_instance(s.paused.test, instance.first_prim);
    return or_leave(phase, view, ray, s, hit, observer);
  }

  // The next phase of the active state; where that is done with an instance, resumes the tree over instances.
  template <class Observer>
  ACCEL_HD static Phase or_leave(Phase phase, const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    if (phase != Phase::done || !s.is_inside) return phase;
    Hit found = hit;
    hit = s.outside;
    if (found.valid()) {
      found.prim_id += s.first_prim;
      accept_hit(found, found.t, hit);
      if (kQuery == Query::any) return Phase::done;
    }
    s.active = s.paused, s.is_inside = false;
    s.ray = ray, s.tree = view.top();
    return is_at_end(view, s, observer) ? Base::end_leaf(s.tree, s.active, hit) : Phase::intersect;
  }

  // Leaves of two-box BVHs list instances as they list triangles, and end in a quad.
  static constexpr bool kHasQuads = requires(const Tree& tree) { tree.leaves; };

  template <class Observer>
  ACCEL_HD static std::uint32_t take_instance(State& s, Observer& observer) {
    std::uint32_t& leaf = Base::leaf(s.active);
    if constexpr (kHasQuads) {
      const LeafQuad& quad = s.tree.leaves[leaf];
      observer.load(Memory::node, &quad, sizeof quad);
      leaf += kQuadsPerTriangle;
      return quad.word;
    } else {
      return leaf++;
    }
  }
  template <class Observer>
  ACCEL_HD static bool is_at_end(const View& view, State& s, Observer& observer) {
    const std::uint32_t leaf = Base::leaf(s.active);
    if constexpr (kHasQuads) {
      observer.load(Memory::node, s.tree.leaves + leaf, sizeof(LeafQuad));
      return is_end_of_leaf(s.tree.leaves, leaf);
    } else {
      return view.instances[leaf - 1].ends_leaf != 0;
    }
  }

  // What names the tree, where an instance does not.
  template <class Observer>
  ACCEL_HD static void tell_tree(const View& view, std::uint32_t tree, Observer& observer) {
    if constexpr (requires { view.trees; })
      if (view.trees != nullptr) observer.load(Memory::node, view.trees + tree, sizeof *view.trees);
  }
};

}  // namespace accel

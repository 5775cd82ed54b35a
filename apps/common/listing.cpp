#include "apps/common/listing.h"

#include "apps/common/table.h"
#include "apps/common/text.h"
#include "libaccel/rays/ray_kind.h"
#include "libaccel/registry/any_accel.h"
#include "scenes/procedural.h"

namespace accel::apps {

std::string listing() {
  using Align = Table::Align;
  Table methods_table({{"METHOD", Align::left}, {"structure", Align::left}, {"", Align::left}});
  for (const MethodInfo& m : methods()) methods_table.add_row({m.name, m.structure, m.name == best_method() ? "best" : ""});

  Table tests_table({{"TRIANGLE TEST", Align::left}, {"", Align::left}});
  for (const std::string& test : triangle_tests())
    tests_table.add_row({test, test == triangle_tests().front() ? "default" : ""});

  Table kinds_table({{"RAYS", Align::left}, {"query", Align::left}, {"", Align::left}});
  for (const RayKindInfo& kind : ray_kinds())
    kinds_table.add_row(
        {std::string(kind.name), kind.query == Query::closest ? "closest hit" : "any hit", std::string(kind.description)});

  Table scenes_table({{"SCENE", Align::left}, {"triangles"}, {"", Align::left}});
  for (const BuiltinScene& scene : builtin_scenes())
    scenes_table.add_row(
        {"builtin:" + std::string(scene.name), with_commas(scene.default_size), std::string(scene.description)});

  return methods_table.text() + "\n" + tests_table.text() + "\n" + kinds_table.text() + "\n" + scenes_table.text();
}

}  // namespace accel::apps

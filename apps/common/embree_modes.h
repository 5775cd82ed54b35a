// The modes of Embree that a run can be timed against.
#pragma once

#include <string_view>

#include "validation/oracle/embree.h"

namespace accel::apps {

struct EmbreeTimed {
  std::string_view name;  // as --embree has it
  validation::EmbreeMode mode;
  validation::EmbreeQuality quality;
  validation::EmbreeCalls calls;
  std::string_view what;
};

// The first one is always timed where Embree is: ratios refer to it. High quality pays where triangles overlap much, and costs
// where spatial splits only add references.
inline constexpr EmbreeTimed kEmbreeModes[] = {
    {"fast", validation::EmbreeMode::fast, validation::EmbreeQuality::medium, validation::EmbreeCalls::single,
     "rtcIntersect1 or rtcOccluded1, medium quality"},
    {"robust", validation::EmbreeMode::robust, validation::EmbreeQuality::medium, validation::EmbreeCalls::single,
     "the same calls in a ROBUST scene, medium quality"},
    {"high", validation::EmbreeMode::fast, validation::EmbreeQuality::high, validation::EmbreeCalls::single,
     "the same calls, high quality"},
    {"packet8", validation::EmbreeMode::fast, validation::EmbreeQuality::high, validation::EmbreeCalls::packets8,
     "rtcIntersect8 or rtcOccluded8, high quality"},
    {"packet16", validation::EmbreeMode::fast, validation::EmbreeQuality::high, validation::EmbreeCalls::packets16,
     "rtcIntersect16 or rtcOccluded16, high quality"},
    {"stream", validation::EmbreeMode::fast, validation::EmbreeQuality::high, validation::EmbreeCalls::streams,
     "rtcIntersectNM or rtcOccludedNM, coherent, high quality"},
    {"packet8-m", validation::EmbreeMode::fast, validation::EmbreeQuality::medium, validation::EmbreeCalls::packets8,
     "as packet8, medium quality"},
    {"packet16-m", validation::EmbreeMode::fast, validation::EmbreeQuality::medium, validation::EmbreeCalls::packets16,
     "as packet16, medium quality"},
    {"stream-m", validation::EmbreeMode::fast, validation::EmbreeQuality::medium, validation::EmbreeCalls::streams,
     "as stream, medium quality"}};

// Whether neighbours are traced together. An application that does so keeps its rays by tiles of pixels.
constexpr bool takes_tiles(const EmbreeTimed& timed) { return timed.calls != validation::EmbreeCalls::single; }

}  // namespace accel::apps

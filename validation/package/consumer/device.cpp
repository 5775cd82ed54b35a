// Asks for the device, as a program does before it uploads anything: the answer is one, or why there is none.
#include <cstdio>

#include <libaccel/exec/cuda/device_accel.h>

int main() {
  const auto info = accel::cuda_device_info();
  std::printf("%s\n", info ? info->name.c_str() : info.error().message.c_str());
  return 0;
}

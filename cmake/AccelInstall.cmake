# Installation and the package config: find_package(libaccel) gives accel::accel.

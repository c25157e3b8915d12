// SPDX-License-Identifier: GPL-3.0-or-later
// tinygltf's code, compiled once. Files, images and Draco are read by our own checked code: its readers are left out.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <fstream>

#include <tiny_gltf.h>

// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/ray_query_engine.h"

#include <chrono>
#include <cstring>

#include "replay/bench/engines/gpu_engine.h"
#include "spirv/bench.h"

namespace zc::bench {
namespace {

// The extension's functions, which the loader does not export.
struct Functions {
  PFN_vkGetAccelerationStructureBuildSizesKHR sizes = nullptr;
  PFN_vkCreateAccelerationStructureKHR create = nullptr;
  PFN_vkDestroyAccelerationStructureKHR destroy = nullptr;
  PFN_vkCmdBuildAccelerationStructuresKHR build = nullptr;
  PFN_vkCmdWriteAccelerationStructuresPropertiesKHR write_properties = nullptr;
  PFN_vkCmdCopyAccelerationStructureKHR copy = nullptr;
  PFN_vkGetAccelerationStructureDeviceAddressKHR address = nullptr;

  explicit Functions(VkDevice device) {
    const auto load = [device](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(vkGetDeviceProcAddr(device, name));
    };
    load(sizes, "vkGetAccelerationStructureBuildSizesKHR");
    load(create, "vkCreateAccelerationStructureKHR");
    load(destroy, "vkDestroyAccelerationStructureKHR");
    load(build, "vkCmdBuildAccelerationStructuresKHR");
    load(write_properties, "vkCmdWriteAccelerationStructuresPropertiesKHR");
    load(copy, "vkCmdCopyAccelerationStructureKHR");
    load(address, "vkGetAccelerationStructureDeviceAddressKHR");
  }
  [[nodiscard]] bool complete() const {
    return sizes != nullptr && create != nullptr && destroy != nullptr && build != nullptr &&
           write_properties != nullptr && copy != nullptr && address != nullptr;
  }
};

struct Structure {
  Buffer buffer;
  VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
};

VkDeviceAddress address_of(Device& device, const Buffer& buffer) {
  VkBufferDeviceAddressInfo info{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  info.buffer = buffer.handle();
  return vkGetBufferDeviceAddress(device.handle(), &info);
}

void after_build(VkCommandBuffer c) {
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
  barrier.dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR;
  vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                       VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0,
                       1, &barrier, 0, nullptr, 0, nullptr);
}

class RayQueryEngine final : public GpuEngine {
 public:
  RayQueryEngine(Device& device, bool any_hit) : GpuEngine(device, any_hit), functions_(device.handle()) {}
  ~RayQueryEngine() override {
    for (const Structure* structure : {&bottom_, &top_})
      if (structure->handle != VK_NULL_HANDLE) functions_.destroy(device().handle(), structure->handle, nullptr);
  }
  [[nodiscard]] std::string name() const override { return "ray_query"; }

  Status build(const BenchScene& scene) override {
    if (!functions_.complete()) return Error{ErrorCode::kDevice, "the driver lacks functions of its extension"};
    const auto start = std::chrono::steady_clock::now();
    ZC_TRY(build_bottom(scene.triangles));
    ZC_TRY(build_top());
    const auto took = std::chrono::steady_clock::now() - start;
    figures_ = {std::chrono::duration<double, std::milli>(took).count(), bottom_.buffer.bytes() + top_.buffer.bytes()};
    KernelOptions options;
    options.spirv = shader::trace_ray_query();
    options.acceleration_structure = true;
    ZC_TRY(set_kernel(std::move(options), {}));
    kernel().bind(top_.handle);
    return {};
  }

 private:
  static constexpr VkBufferUsageFlags kInput =
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

  Status build_bottom(std::span<const BenchTriangle> triangles) {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    ZC_ASSIGN(const Buffer vertices, make_filled_buffer(device(), std::as_bytes(triangles), kInput));
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    auto& data = geometry.geometry.triangles;
    data = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
    data.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    data.vertexData.deviceAddress = address_of(device(), vertices);
    data.vertexStride = 12;
    data.maxVertex = 3 * count - 1;
    data.indexType = VK_INDEX_TYPE_NONE_KHR;
    ZC_ASSIGN(bottom_, build_structure(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, geometry, count,
                                       VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR));
    return compact(bottom_);
  }

  Status build_top() {
    VkAccelerationStructureDeviceAddressInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    info.accelerationStructure = bottom_.handle;
    VkAccelerationStructureInstanceKHR instance{};
    for (std::size_t i = 0; i < 3; ++i) instance.transform.matrix[i][i] = 1;
    instance.mask = 0xFF;
    instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    instance.accelerationStructureReference = functions_.address(device().handle(), &info);
    ZC_ASSIGN(const Buffer instances, make_filled_buffer(device(), std::as_bytes(std::span(&instance, 1)), kInput));
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    geometry.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
    geometry.geometry.instances.data.deviceAddress = address_of(device(), instances);
    ZC_ASSIGN(top_, build_structure(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, geometry, 1, 0));
    return {};
  }

  Result<Structure> create_structure(VkAccelerationStructureTypeKHR type, VkDeviceSize bytes) {
    Structure structure;
    ZC_ASSIGN(structure.buffer, Buffer::create(device(), bytes,
                                               VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                                                   VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                                               MemoryUse::kDevice));
    VkAccelerationStructureCreateInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    info.buffer = structure.buffer.handle();
    info.size = bytes;
    info.type = type;
    ZC_VK(functions_.create(device().handle(), &info, nullptr, &structure.handle));
    return structure;
  }

  Result<Structure> build_structure(VkAccelerationStructureTypeKHR type,
                                    const VkAccelerationStructureGeometryKHR& geometry, std::uint32_t primitives,
                                    VkBuildAccelerationStructureFlagsKHR more_flags) {
    VkAccelerationStructureBuildGeometryInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR | more_flags;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    VkAccelerationStructureBuildSizesInfoKHR sizes{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    functions_.sizes(device().handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &primitives, &sizes);
    ZC_ASSIGN(Structure structure, create_structure(type, sizes.accelerationStructureSize));
    // Its address must be a multiple of what the device asks for; 256 is the most that the specification allows.
    constexpr VkDeviceSize kScratchAlignment = 256;
    ZC_ASSIGN(const Buffer scratch,
              Buffer::create(device(), sizes.buildScratchSize + kScratchAlignment,
                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                             MemoryUse::kDevice));
    info.dstAccelerationStructure = structure.handle;
    info.scratchData.deviceAddress =
        (address_of(device(), scratch) + kScratchAlignment - 1) / kScratchAlignment * kScratchAlignment;
    const VkAccelerationStructureBuildRangeInfoKHR range{primitives, 0, 0, 0};
    const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
    const Status built = device().run([&](VkCommandBuffer c) {
      functions_.build(c, 1, &info, &ranges);
      after_build(c);
    });
    if (!built.ok()) {
      functions_.destroy(device().handle(), structure.handle, nullptr);
      return built.error();
    }
    return structure;
  }

  Status compact(Structure& structure) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    info.queryCount = 1;
    VkQueryPool pool = VK_NULL_HANDLE;
    ZC_VK(vkCreateQueryPool(device().handle(), &info, nullptr, &pool));
    std::uint64_t bytes = 0;
    Status asked = device().run([&](VkCommandBuffer c) {
      vkCmdResetQueryPool(c, pool, 0, 1);
      functions_.write_properties(c, 1, &structure.handle, info.queryType, pool, 0);
    });
    if (asked.ok())
      asked = vk_status(vkGetQueryPoolResults(device().handle(), pool, 0, 1, sizeof(bytes), &bytes, sizeof(bytes),
                                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                        "vkGetQueryPoolResults");
    vkDestroyQueryPool(device().handle(), pool, nullptr);
    ZC_TRY(std::move(asked));
    if (bytes == 0 || bytes >= structure.buffer.bytes()) return {};
    ZC_ASSIGN(Structure small, create_structure(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, bytes));
    VkCopyAccelerationStructureInfoKHR copy{VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR};
    copy.src = structure.handle;
    copy.dst = small.handle;
    copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    Status copied = device().run([&](VkCommandBuffer c) {
      functions_.copy(c, &copy);
      after_build(c);
    });
    std::swap(structure, small);  // whichever is not kept goes now, the kept one with the engine
    functions_.destroy(device().handle(), small.handle, nullptr);
    return copied;
  }

  Functions functions_;
  Structure bottom_, top_;
};

}  // namespace

std::unique_ptr<TraceEngine> make_ray_query_engine(Device& device, bool any_hit) {
  return std::make_unique<RayQueryEngine>(device, any_hit);
}

}  // namespace zc::bench

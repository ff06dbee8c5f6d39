#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/system.hpp>

#include "folder.hpp"
#include "scene/npy.hpp"
#include "scenes.hpp"

namespace tanor::report {

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline nlohmann::json read_json(const std::filesystem::path& path) {
  return nlohmann::json::parse(read_text(path));
}

inline scene::NpyArray read_npy(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  std::string_view bytes = text;
  scene::NpyArray array = scene::read_npy(path.string(), &bytes);
  if (!bytes.empty()) throw std::runtime_error("something follows the array in " + path.string());
  return array;
}

inline std::size_t count_lines(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

inline std::vector<std::string> list_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// One frame of an extended XYZ file.
struct XyzFrame {
  double time = 0.0;
  std::vector<std::string> species;
  std::vector<double> positions, velocities;  // 3m
};

inline std::vector<XyzFrame> read_xyz(const std::filesystem::path& path) {
  std::vector<XyzFrame> frames;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    XyzFrame frame;
    const std::size_t num_points = std::stoul(line);
    std::getline(stream, line);
    const std::string header = "Properties=species:S:1:pos:R:3:velo:R:3 Time=";
    if (!line.starts_with(header)) throw std::runtime_error("bad header: " + line);
    frame.time = std::stod(line.substr(header.size()));
    for (std::size_t k = 0; k < num_points; ++k) {
      if (!std::getline(stream, line)) throw std::runtime_error("frame cut short");
      std::istringstream row(line);
      std::string species;
      row >> species;
      frame.species.push_back(species);
      for (std::vector<double>* array : {&frame.positions, &frame.velocities}) {
        for (int axis = 0; axis < 3; ++axis) {
          double number;
          if (!(row >> number)) throw std::runtime_error("bad row: " + line);
          array->push_back(number);
        }
      }
    }
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace tanor::report

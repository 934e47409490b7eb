#include "io/dicom_frames.h"

#include <algorithm>

#include "io/dicom_tags.h"

namespace vasamesh {
namespace {

using gdcm::DataSet;
using gdcm::Tag;

const Tag kSharedGroups(0x5200, 0x9229), kGroupsOfFrames(0x5200, 0x9230);
const Tag kPlanePosition(0x0020, 0x9113), kPlaneOrientation(0x0020, 0x9116);
const Tag kPixelMeasures(0x0028, 0x9110), kValueTransformation(0x0028, 0x9145);
const Tag kSegmentIdentification(0x0062, 0x000a);

DataSet first_item(const DataSet& set, const Tag& sequence) {
  const std::vector<DataSet> items = dicom_items(set, sequence);
  return items.empty() ? DataSet() : items.front();
}

/// The elements of `group` override those there are.
void read_position(const DataSet& group, DicomFrame& frame) {
  const auto p = dicom_numbers(group, Tag(0x0020, 0x0032));
  if (p.size() == 3) frame.position = {p[0], p[1], p[2]};
}

void read_orientation(const DataSet& group, DicomFrame& frame) {
  const auto o = dicom_numbers(group, Tag(0x0020, 0x0037));
  if (o.size() == 6) frame.orientation = {{{o[0], o[1], o[2]}, {o[3], o[4], o[5]}}};
}

void read_measures(const DataSet& group, DicomFrame& frame) {
  const auto spacing = dicom_numbers(group, Tag(0x0028, 0x0030));  // between rows comes first
  if (spacing.size() == 2) frame.spacing = {spacing[1], spacing[0]};
  const auto thickness = dicom_numbers(group, Tag(0x0018, 0x0050));
  if (thickness.size() == 1) frame.thickness = thickness.front();
}

void read_groups(const DataSet& groups, DicomFrame& frame) {
  read_position(first_item(groups, kPlanePosition), frame);
  read_orientation(first_item(groups, kPlaneOrientation), frame);
  read_measures(first_item(groups, kPixelMeasures), frame);
  const DataSet values = first_item(groups, kValueTransformation);
  if (!values.IsEmpty())
    frame.rescaling =
        dicom_text(values, Tag(0x0028, 0x1053)) + " " + dicom_text(values, Tag(0x0028, 0x1052));
  const DataSet segment = first_item(groups, kSegmentIdentification);
  frame.segment = dicom_unsigned(segment, Tag(0x0062, 0x000b)).value_or(frame.segment);
}

}  // namespace

std::vector<DicomFrame> dicom_frames(const DataSet& set, std::int64_t count) {
  DicomFrame common;
  read_orientation(set, common);
  read_measures(set, common);
  if (count == 1) read_position(set, common);
  read_groups(first_item(set, kSharedGroups), common);
  const std::vector<DataSet> groups = dicom_items(set, kGroupsOfFrames);
  std::vector<DicomFrame> frames(std::max<std::size_t>(groups.size(), count == 1), common);
  for (std::size_t i = 0; i < groups.size(); ++i) read_groups(groups[i], frames[i]);
  return frames;
}

}  // namespace vasamesh

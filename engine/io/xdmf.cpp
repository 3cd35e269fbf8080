// The XDMF 3 file beside a run's HDF5 file.
#include "engine/io/xdmf.h"

#include "engine/io/folder.h"

#include <fmt/format.h>

namespace pliant {

XdmfWriter::XdmfWriter(std::filesystem::path path, std::string data_file)
    : path_(std::move(path)), data_file_(std::move(data_file)),
      text_("<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\"><Domain>"
            "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n") {}

std::string XdmfWriter::item(const std::string& path, const char* type, int bytes,
                             const std::string& size) const {
  return fmt::format(
      "<DataItem Format=\"HDF\" NumberType=\"{}\" Precision=\"{}\" Dimensions=\"{}\">{}:{}</DataItem>", type,
      bytes, size, data_file_, path);
}

void XdmfWriter::begin_frame(double time) {
  text_ += fmt::format(
      "<Grid Name=\"step\" GridType=\"Collection\" CollectionType=\"Spatial\"><Time Value=\"{}\"/>\n", time);
}

void XdmfWriter::add_body(const BodyOutput& body, const std::string& folder, std::uint64_t points,
                          const std::string& corners, std::uint64_t triangles) {
  text_ += fmt::format("<Grid Name=\"{}\">", body.name);
  // Without explicit ids ParaView's default reader makes no cells of a Polyvertex, and draws nothing.
  if (body.kind == BodyOutput::Kind::particles)
    text_ += fmt::format(
        "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">{}</Topology>",
        points, item(folder + "/id", "Int", 4, fmt::format("{} 1", points)));
  else
    text_ += fmt::format("<Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>",
                         triangles, item(corners, "Int", 8, fmt::format("{} 3", triangles)));
  text_ += fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>",
                       item(folder + "/position", "Float", 4, fmt::format("{} 3", points)));
  for (const FieldSpec& field : body.fields) {
    const bool vector = field.components == 3;
    text_ += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>",
                         field.name, vector ? "Vector" : "Scalar",
                         item(folder + "/" + field.name, "Float", 4,
                              vector ? fmt::format("{} 3", points) : fmt::format("{}", points)));
  }
  text_ += "</Grid>\n";
}

void XdmfWriter::end_frame() {
  text_ += "</Grid>\n";
}

void XdmfWriter::write(bool now) {
  constexpr std::size_t short_text = 4 << 20;
  if (text_.size() == written_ ||
      (!now && text_.size() > short_text && text_.size() < written_ + written_ / 64))
    return;
  write_text_file(path_, text_ + "</Grid></Domain></Xdmf>\n");
  written_ = text_.size();
}

} // namespace pliant

// A detector that answers in every way there is, for the tests.

#include "scanbench.hpp"

int main() {
    return scanbench::serve(
        "drawn",
        [](const scanbench::Configuration& configuration) -> scanbench::Detect {
            const auto& given = configuration.parameters;
            const std::string how = given.text("how", "clusters");
            const double shift_m = given.number("shift_m", 0.0) + configuration.sensor_height_m.value_or(0.0);
            const bool really = given.flag("really", true);
            long n_scans = given.integer("n_scans", 0);
            return [=](const scanbench::Cloud& cloud) mutable {
                scanbench::Detections found;
                ++n_scans;
                const float x_m = static_cast<float>(n_scans);
                const scanbench::Box box{x_m, static_cast<float>(shift_m), -1.0F, 4.0F, 2.0F, 1.5F, 0.5F};
                for (std::size_t i = 0; i < cloud.n_points; ++i) {
                    found.clusters.push_back(cloud.ring ? cloud.ring[i] : cloud.x_m[i] > 0.0F ? 4 : cloud.intensity ? 9 : 0);
                }
                if (how == "boxes") {
                    found.has_clusters = false;
                    found.clusters.clear();
                    found.boxes = {box, box};
                    found.scores = {0.25F, -1.0F};
                    found.classes = {"car", std::nullopt};
                } else if (how == "both") {
                    found.boxes.assign(9, box);
                } else if (how == "everything") {
                    found.scores = {1.0F, 2.0F};
                    found.classes = {std::nullopt, "tram"};
                    found.stages = {{"a \"stage\" \xc3\xa9", 1.25}, {"late", 1e12}};
                    found.products = {{"ground", std::vector<std::uint8_t>(cloud.n_points, 7)}};
                } else if (how == "short") {
                    found.clusters.pop_back();
                } else if (how == "nan") {
                    found.boxes.assign(9, box);
                    found.boxes[3].yaw_rad = std::nanf("");
                } else if (how == "scores") {
                    found.scores = {1.0F};
                } else if (how == "product") {
                    found.products = {{"ground", {1}}};
                } else if (how == "products") {
                    found.products.assign(33, {"ground", std::vector<std::uint8_t>(cloud.n_points, 7)});
                } else if (how == "name") {
                    found.stages = {{"a\n", 1.0}};
                } else if (how == "throws") {
                    throw std::runtime_error(really ? "out of \"tea\"\n\tand m\xc3\xbcsli" : "no");
                }
                return found;
            };
        },
        "0.1");
}

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
            const long n_back = given.integer("n_back", 0);
            configuration.look_back(static_cast<std::size_t>(n_back), how == "back");
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
                } else if (how == "back") {
                    if (cloud.begins_drive) n_scans = 1;
                    std::vector<scanbench::Cloud> clouds = cloud.earlier;
                    clouds.insert(clouds.begin(), cloud);
                    found.has_clusters = false;
                    found.clusters.clear();
                    const double pose_m = cloud.world_from_sensor ? (*cloud.world_from_sensor)[3] : 0.0;
                    for (const auto& it : clouds) {
                        const float y_m = static_cast<float>(n_scans), z_m = static_cast<float>(pose_m);
                        found.boxes.push_back({it.x_m[0], y_m, z_m, 1.0F, 1.0F, 1.0F, 0.0F});
                        const float before_s = static_cast<float>(cloud.time_s - it.time_s);
                        const float along = before_s > 0.0F ? (cloud.x_m[0] - it.x_m[0]) / before_s : std::nanf("");
                        found.velocities.push_back({along, before_s > 0.0F ? 0.0F : std::nanf("")});
                        const auto number = static_cast<std::uint32_t>(found.tracks.size());
                        found.tracks.push_back(number == 0 ? scanbench::NO_TRACK : number - 1);
                    }
                } else if (how == "speed") {
                    found.velocities.assign(2, {1.0F, 1001.0F});
                } else if (how == "tracks") {
                    found.tracks = {1};
                } else if (how == "throws") {
                    throw std::runtime_error(really ? "out of \"tea\"\n\tand m\xc3\xbcsli" : "no");
                }
                return found;
            };
        },
        "0.1");
}

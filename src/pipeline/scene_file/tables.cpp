#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

/// Visitor: fields go to their table, tables inside a table behind it.
class TableList : public FieldList {
  public:
    TableList(Tables& tables, const Scene& scene, FileNames& files)
        : FieldList(tables.emplace_back().fields, &scene, &files), tables_(tables) {}

    template <class... S>
    void table(const char* name, S&... descs) {
        open({.name = name}, descs...);
    }
    template <class S>
    void table(const char* name, std::optional<S>& desc) {
        if (desc) open({.name = name}, *desc);
    }
    template <class S, class... More>
    void list(const char* name, std::vector<S>& descs, std::vector<More>&... more) {
        for (std::size_t i = 0; i < descs.size(); ++i)
            open({.name = name, .path = entry(name, i), .listed = true}, descs[i], more.at(i)...);
    }
    template <class S>
    void one_of_a_list(const char* name, S& desc) {
        open({.name = name, .path = entry(name, 0), .listed = true}, desc);
    }

  private:
    template <class... S>
    void open(Table table, S&... descs) {
        if (table.path.empty()) table.path = table.name;
        const std::string outer_name = name_, outer_path = path_;
        Fields* outer = fields_;
        if (!outer_name.empty()) {
            table.name = outer_name + "." + table.name;
            table.path = outer_path + "." + table.path;
        }
        name_ = table.name;
        path_ = table.path;
        fields_ = &tables_.emplace_back(std::move(table)).fields;
        (describe(*this, descs), ...);
        name_ = outer_name;
        path_ = outer_path;
        fields_ = outer;
    }

    Tables& tables_;
    std::string name_;
};

}  // namespace

std::string entry(const std::string& table, std::size_t index) {
    return fmt::format("{}[{}]", table, index);
}

Tables tables_of(SceneFile& file, FileNames& files) {
    Tables tables;
    TableList list(tables, file.scene, files);
    describe(list, file);
    return tables;
}

SceneFile scene_of_each() {
    SceneFile file;
    file.scene.cloths.resize(1);
    file.scene.cloths[0].fabric = {};  // what a table of numbers begins with
    file.scene.parts.resize(1);
    file.scene.parts[0].fabric = {};
    file.scene.colliders.resize(1);
    file.scene.pins.resize(1);
    file.scene.seams.resize(1);
    file.scene.drags.resize(1);
    file.scene.events.resize(1);
    file.looks.cloths.resize(1);
    file.looks.colliders.resize(1);
    file.looks.ground.emplace();
    return file;
}

const std::vector<RootTable>& root_tables() {
    static const std::vector<RootTable> roots = [] {
        SceneFile each = scene_of_each();
        std::vector<RootTable> names;
        for (const Table& t : tables_of(each, each.files)) {
            if (!t.name.empty() && t.name.find('.') == t.name.npos) names.push_back({t.name, t.listed});
        }
        return names;
    }();
    return roots;
}

}  // namespace cloth::pipeline

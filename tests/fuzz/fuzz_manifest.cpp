// Manifests and ledgers of kept runs: read, or refused with an Error; of a ledger what makes sense is taken.

#include "fuzz/file_of_input.h"
#include "pipeline/formats/error.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run_folder.h"

using namespace cloth::pipeline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const RunFolder folder = RunFolder::create(folder_of_inputs());
    file_of(data, size, "states/manifest.json");
    file_of(data, size, "ledger.jsonl");
    try {
        folder.read_manifest();
    } catch (const Error&) {
    }
    read_frame_reports(folder);
    return 0;
}

#include "pipeline/sweep/expression.h"

#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <muParser.h>

namespace cloth::pipeline {

struct Expression::Parser {
    mu::Parser parser;
    std::deque<double> values;               // stay where they are when more are added
    std::map<std::string, double*> by_name;  // into them
};

namespace {

/// muParser would take it for an assignment, which is true where it is not 0.
bool has_lone_equals(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '=') continue;
        if (i + 1 < text.size() && text[i + 1] == '=') {
            ++i;
            continue;
        }
        if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) return true;
    }
    return false;
}

double rounded(double value) {
    return std::round(value);
}

}  // namespace

Expression::Expression(const std::string& text) : text_(text), parser_(std::make_shared<Parser>()) {
    if (text.find_first_not_of(" \t") == text.npos) throw std::invalid_argument("is empty");
    if (has_lone_equals(text)) throw std::invalid_argument("has a single =; to compare write ==");
    mu::Parser& parser = parser_->parser;
    try {
        parser.ClearConst();
        parser.DefineNameChars("0123456789_.[]abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ");
        parser.DefineConst("pi", std::numbers::pi);
        parser.DefineConst("e", std::numbers::e);
        parser.DefineFun("round", rounded);
        parser.SetVarFactory(
            [](const char* name, void* self) -> double* {
                Parser& own = *static_cast<Parser*>(self);
                double* place = &own.values.emplace_back(0.0);
                own.by_name.emplace(name, place);
                return place;
            },
            parser_.get());
        parser.SetExpr(text);
        int results = 0;
        parser.Eval(results);
        if (results != 1) throw std::invalid_argument("has several expressions; give one");
    } catch (const mu::Parser::exception_type& error) {
        throw std::invalid_argument(fmt::format("cannot be understood: {}", error.GetMsg()));
    }
    for (const auto& [name, place] : parser_->by_name) names_.push_back(name);
}

double Expression::at(const NameValue& value) const {
    for (const auto& [name, place] : parser_->by_name) *place = value(name);
    double result = 0.0;
    try {
        result = parser_->parser.Eval();
    } catch (const mu::Parser::exception_type& error) {
        throw std::invalid_argument(error.GetMsg());
    }
    if (!std::isfinite(result)) throw std::invalid_argument(fmt::format("is {}, which is no number", result));
    return result;
}

}  // namespace cloth::pipeline

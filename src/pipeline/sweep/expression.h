#pragma once
// Arithmetic on the keys of a scene: "0.6 * cloth.fabric.bending", "bending < 1e-4 && friction > 0.1".

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cloth::pipeline {

/// A name of an expression and what it stands for.
using NameValue = std::function<double(const std::string& name)>;

/// muParser's arithmetic in doubles: + - * / ^, comparisons, && || and ?:, functions such as sqrt, abs, min,
/// max, ln, log10, exp, sin, round, and the constants pi and e. Names have letters, digits, points, _ and
/// [0]. Numbers are written with a point, whatever the locale.
class Expression {
  public:
    /// Throws std::invalid_argument saying what is wrong: an assignment (= for ==), several expressions, what
    /// muParser does not understand.
    explicit Expression(const std::string& text);

    const std::string& text() const { return text_; }
    /// Names that have to be known, sorted.
    const std::vector<std::string>& names() const { return names_; }
    /// Throws what `value` throws, and std::invalid_argument where the result is not finite.
    double at(const NameValue& value) const;

  private:
    struct Parser;
    std::string text_;
    std::vector<std::string> names_;
    std::shared_ptr<Parser> parser_;
};

}  // namespace cloth::pipeline

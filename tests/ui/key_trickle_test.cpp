#include "ui/window/gl/key_trickle.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace kerf::key_trickle_test {
namespace {

constexpr int kBackspace = 259, kControl = 341;

void tap(KeyTrickle& keys, int key, int modifiers = 0) {
  keys.add({.key = key, .action = 1, .modifiers = modifiers});
  keys.add({.key = key, .action = 0, .modifiers = modifiers});
}

void type(KeyTrickle& keys, char c) {
  const int key = c - 'a' + 'A';
  keys.add({.key = key, .action = 1});
  keys.add({.character = static_cast<unsigned char>(c)});
  keys.add({.key = key, .action = 0});
}

// Model of a text field in Dear ImGui 1.86: per frame first the characters, then the pressed keys.
struct Field {
  std::string text;
  std::set<int> down;

  void frame(KeyTrickle& keys) {
    std::set<int> before = down;
    std::string typed;
    for (const KeyTrickle::Event& e : keys.takeFrame()) {
      if (e.character)
        typed += static_cast<char>(e.character);
      else if (e.action == 0)
        down.erase(e.key);
      else
        down.insert(e.key);
    }
    text += typed;
    const auto isPressed = [&](int key) { return down.count(key) > 0 && before.count(key) == 0; };
    if (isPressed(kBackspace) && !text.empty()) text.pop_back();
    if (isPressed('A') && down.count(kControl) > 0) text.clear();
  }
};

TEST(KeyTrickle, SixTapsInOneFrameAreSix) {
  KeyTrickle keys;
  Field field{"abcdefgh", {}};
  for (int n = 0; n < 6; ++n) tap(keys, kBackspace);
  for (int n = 0; n < 12; ++n) field.frame(keys);
  EXPECT_EQ(field.text, "ab");
  EXPECT_TRUE(field.down.empty());
}

TEST(KeyTrickle, AWordTypedInOneFrameIsThereInIt) {
  KeyTrickle keys;
  Field field;
  for (const char c : std::string("seen")) type(keys, c);
  field.frame(keys);
  EXPECT_EQ(field.text, "seen");
  for (int n = 0; n < 4; ++n) field.frame(keys);
  EXPECT_TRUE(field.down.empty()) << "every key that was let go is up";
}

TEST(KeyTrickle, WhatIsTypedAfterAKeyComesAfterIt) {
  KeyTrickle keys;
  Field field;
  type(keys, 'x');
  tap(keys, kBackspace);
  type(keys, 'y');
  keys.add({.key = kControl, .action = 1});
  tap(keys, 'A', 2);
  keys.add({.key = kControl, .action = 0});
  type(keys, 'z');
  for (int n = 0; n < 8; ++n) field.frame(keys);
  EXPECT_EQ(field.text, "z") << "all was chosen and deleted before z came";
  EXPECT_TRUE(field.down.empty());
}

TEST(KeyTrickle, NothingIsLostOfRandomTaps) {
  unsigned random = 1;
  const auto next = [&](unsigned below) { return (random = random * 1664525 + 1013904223) / 65536 % below; };
  for (int round = 0; round < 200; ++round) {
    KeyTrickle keys;
    Field field;
    std::string wanted;
    for (int n = 0; n < 30; ++n) {
      if (next(3) == 0) {
        tap(keys, kBackspace);
        if (!wanted.empty()) wanted.pop_back();
      } else {
        const char c = static_cast<char>('a' + next(26));
        type(keys, c);
        wanted += c;
      }
      if (next(4) == 0) field.frame(keys);
    }
    for (int n = 0; n < 100; ++n) field.frame(keys);
    ASSERT_EQ(field.text, wanted) << round;
    ASSERT_TRUE(field.down.empty());
  }
}

}  // namespace
}  // namespace kerf::key_trickle_test

#include <cornerfix/answer.hpp>

namespace cornerfix {

std::string_view to_string(Status status) {
  switch (status) {
    case Status::kCollecting:
      return "collecting";
    case Status::kAmbiguous:
      return "ambiguous";
    case Status::kLocalized:
      return "localized";
    case Status::kLost:
      return "lost";
  }
  return "collecting";
}

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::kNone:
      return "";
    case Reason::kNoReturns:
      return "no_returns";
    case Reason::kFewFeatures:
      return "few_features";
    case Reason::kNoMotion:
      return "no_motion";
    case Reason::kNoMatch:
      return "no_match";
    case Reason::kFewEvidence:
      return "few_evidence";
    case Reason::kContradicted:
      return "contradicted";
    case Reason::kOdometryContradictsScans:
      return "odometry_contradicts_scans";
    case Reason::kSearching:
      return "searching";
    case Reason::kPriorContradicted:
      return "prior_contradicted";
    case Reason::kMirroredScans:
      return "mirrored_scans";
  }
  return "";
}

std::string_view to_string(OdometryUse use) {
  switch (use) {
    case OdometryUse::kNone:
      return "none";
    case OdometryUse::kUsed:
      return "used";
    case OdometryUse::kWeightedDown:
      return "weighted_down";
    case OdometryUse::kIgnored:
      return "ignored";
  }
  return "none";
}

std::string_view to_string(Withdrawal withdrawal) {
  switch (withdrawal) {
    case Withdrawal::kNone:
      return "";
    case Withdrawal::kScansLost:
      return "scans_lost";
    case Withdrawal::kContradicted:
      return "contradicted";
    case Withdrawal::kRival:
      return "rival";
  }
  return "";
}

}  // namespace cornerfix
